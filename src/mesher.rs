//! The whole algorithm on one screen.

use std::time::{Duration, Instant};

use crate::error::Error;
use crate::extract::{self, Sampling};
use crate::improve;
use crate::params::{Boundary, Params};
use crate::progress::{Observer, Stage};
use crate::refine;
use crate::relax::{Relaxation, Stopped};
use crate::seeds::{self, InitialPoints};
use crate::surface::Surface;
use crate::surface::features::Features;
use crate::tet_mesh::{SizeRatio, TetMesh};

/// Iterations against slivers, at most.
const MOST_AGAINST_SLIVERS: usize = 4;

/// The iterations before the surface is followed end at so many times the tolerance: those after it do the rest.
const SETTLED: f64 = 30.0;

/// The longest time limit, in seconds: a clock may not count further.
const LONGEST: f64 = 1e9;

/// Meshes the solid that `surface` bounds, with exactly as many vertices as `params` ask for.
///
/// # Errors
/// [`Error::Parameter`] for values that no run could honour, [`Error::TooFewSeeds`] where the count is too small for a
/// valid mesh, [`Error::Interrupted`] where the observer stopped the run before there was a mesh.
pub fn tetrahedralize(surface: &Surface, params: &Params, observer: &mut dyn Observer) -> Result<TetMesh, Error> {
    run(surface, None, params, observer)
}

/// The same from the points of an earlier mesh, as many as `params` ask for: point i becomes vertex i, moved as little as a good
/// mesh of a surface that moved allows.
///
/// The seeds stay near where they are: none is taken elsewhere to follow the surface closer, and the improvement neither
/// splits nor contracts edges. Only where there would be no valid mesh a seed may still move far.
///
/// # Errors
/// Those of [`tetrahedralize`]; [`Error::Parameter`] too where the points are no mesh of a surface near this one, or not as
/// many as asked for.
pub fn tetrahedralize_from(
    surface: &Surface,
    initial: &InitialPoints,
    params: &Params,
    observer: &mut dyn Observer,
) -> Result<TetMesh, Error> {
    run(surface, Some(initial), params, observer)
}

fn run(
    surface: &Surface,
    initial: Option<&InitialPoints>,
    params: &Params,
    observer: &mut dyn Observer,
) -> Result<TetMesh, Error> {
    params.validate()?;
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(params.threads)
        .build()
        .map_err(|e| Error::Parameter { option: "threads", reason: e.to_string() })?;
    pool.install(|| mesh(surface, initial, params, observer))
}

fn mesh(
    surface: &Surface,
    initial: Option<&InitialPoints>,
    params: &Params,
    observer: &mut dyn Observer,
) -> Result<TetMesh, Error> {
    let deadline = params.time_limit.map(|s| Instant::now() + Duration::from_secs_f64(s.min(LONGEST)));

    // 1. Seeds on corners, creases and the surface, and inside: new ones, or the points of an earlier mesh.
    observer.stage(Stage::Seeds);
    let started = Instant::now();
    let features = Features::find(surface, params.feature_angle);
    let sizing = seeds::sizing(surface, &features, params)?;
    // Where sizes vary, the surface is split until they are nearly linear on its triangles.
    let refined = match (&sizing, initial) {
        (Some(sizing), _) => Some(sizing.refined(surface)),
        (None, None) => seeds::refined(surface, &features, params)?,
        (None, Some(_)) => None,
    };
    let (surface, features) = match &refined {
        None => (surface, features),
        Some(refined) => (refined, Features::find(refined, params.feature_angle)),
    };
    let seeds = match initial {
        None => seeds::sample_sized(surface, &features, params, sizing)?,
        Some(initial) => seeds::initial::from_points(surface, &features, initial, params, sizing)?,
    };
    let seeds_s = started.elapsed().as_secs_f64();
    observer.seeds(None, &seeds.positions, surface.frame());

    // 2. To a centroidal Voronoi tessellation of the solid.
    observer.stage(Stage::Relax { iterations: params.iterations });
    let mut relaxation = Relaxation::new(surface, &features, params, seeds, deadline)?;
    let follows = params.boundary == Boundary::Conform && initial.is_none();
    let at_first = (params.iterations / 2).saturating_sub(1);
    let tolerance = if follows { SETTLED * params.tolerance } else { params.tolerance };
    let mut stopped = relaxation.run_within(at_first, tolerance, observer)?;
    // What need not be done at first need not be done later.
    let saved = if follows { at_first - relaxation.iterations() } else { 0 };
    let iterations = params.iterations - saved;
    if follows && !stopped.is_interruption() && params.iterations > 0 {
        stopped = refine::follow_surface(&mut relaxation, surface, iterations, params, observer)?;
    }
    // The last few are against slivers.
    let against_slivers = MOST_AGAINST_SLIVERS.min(iterations / 6);
    let iterations = iterations - against_slivers;
    if !stopped.is_interruption() {
        let before_last = iterations * 9 / 10;
        stopped = relaxation.run(before_last.saturating_sub(relaxation.iterations()), observer)?;
    }

    // 3. More seeds where a valid mesh needs them, before the last iterations; what these break is mended once more.
    observer.stage(Stage::Extract);
    let solid = (surface, &features);
    let started = Instant::now();
    let moved_s = relaxation.moving_time();
    let made = relaxation.iterations();
    let mut inside = refine::until_valid(&mut relaxation, solid, params, observer, stopped.is_interruption())?;
    let is_sound = relaxation.iterations() == made;
    if stopped == Stopped::Iterations && relaxation.iterations() < iterations {
        stopped = relaxation.run(iterations - relaxation.iterations(), observer)?;
        // What needed nothing is looked at once more in the end, where that is yet to come.
        let is_end = stopped.is_interruption() || against_slivers == 0;
        if is_end || !is_sound {
            inside = refine::until_valid(&mut relaxation, solid, params, observer, stopped.is_interruption())?;
        }
    }
    if !stopped.is_interruption() && against_slivers > 0 {
        let last = relaxation.reduce_slivers(against_slivers, observer)?;
        stopped = if last.is_interruption() { last } else { stopped };
        inside = refine::until_valid(&mut relaxation, solid, params, observer, last.is_interruption())?;
    }
    observer.triangulation(relaxation.delaunay(), surface);

    // 4. The restricted Delaunay tets and their boundary.
    let kinds = relaxation.seeds().kinds();
    let sampling = Sampling::new(relaxation.delaunay(), &kinds, surface, relaxation.seeds().spacings());
    // The input's own patches, or else the smooth pieces between its creases.
    let patch = if surface.has_patches() { surface.patch() } else { &features.face };
    let mut mesh = extract::mesh(&sampling, &inside, patch);
    let extract_s = started.elapsed().as_secs_f64();

    // 5. Slivers out.
    let started = Instant::now();
    if params.improve {
        observer.stage(Stage::Improve);
        mesh.improved = improve::improve(&mut mesh, relaxation.seeds(), (surface, &features, patch), params, observer);
        refine::check_volumes(&mesh, solid, params, relaxation.seeds())?;
    }
    mesh.check().map_err(Error::Broken)?;
    let improve_s = started.elapsed().as_secs_f64();
    mesh.turn_interfaces(|region| surface.depth_of_shell(region));

    mesh.size_ratio = SizeRatio::of(&mesh, relaxation.seeds(), surface);
    mesh.stopped = describe(stopped, params, (relaxation.iterations(), saved));
    (mesh.steps, mesh.times) = relaxation.into_record();
    mesh.times.seeds = seeds_s;
    mesh.times.extract = extract_s - (mesh.times.update + mesh.times.centroids - moved_s);
    mesh.times.improve = improve_s;
    Ok(mesh)
}

fn describe(stopped: Stopped, params: &Params, (made, saved): (usize, usize)) -> String {
    match stopped {
        Stopped::Iterations if made < params.iterations && saved > 0 => "the seeds settled early".to_string(),
        Stopped::Iterations if made < params.iterations => "one step more against slivers left no fewer".to_string(),
        Stopped::Iterations if made > params.iterations => "as many as a valid mesh needed".to_string(),
        Stopped::Iterations => "as many as were asked for".to_string(),
        Stopped::Tolerance => format!("the energy changed by less than {:e} of itself", params.tolerance),
        Stopped::Time => "the time limit was reached".to_string(),
        Stopped::Caller => "stopped by the caller".to_string(),
    }
}
