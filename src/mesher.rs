//! The whole algorithm on one screen.

use std::time::Instant;

use crate::error::Error;
use crate::extract::{self, Sampling};
use crate::improve;
use crate::lloyd::{Relaxation, Stopped};
use crate::params::{Boundary, Params};
use crate::progress::{Observer, Stage};
use crate::refine;
use crate::seeds;
use crate::surface::Surface;
use crate::surface::features::Features;
use crate::tet_mesh::TetMesh;

/// Meshes the solid that `surface` bounds, with exactly as many vertices as `params` ask for.
///
/// # Errors
/// [`Error::Parameter`] for values that no run could honour, [`Error::TooFewSeeds`] where the count is too small for a
/// valid mesh, [`Error::Interrupted`] where the observer stopped the run before there was a mesh.
pub fn tetrahedralize(surface: &Surface, params: &Params, observer: &mut dyn Observer) -> Result<TetMesh, Error> {
    params.validate()?;
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(params.threads)
        .build()
        .map_err(|e| Error::Parameter { option: "threads", reason: e.to_string() })?;
    pool.install(|| mesh(surface, params, observer))
}

fn mesh(surface: &Surface, params: &Params, observer: &mut dyn Observer) -> Result<TetMesh, Error> {
    // 1. Seeds on corners, creases and the surface, and inside.
    observer.stage(Stage::Seeds);
    let started = Instant::now();
    let features = Features::find(surface, params.feature_angle);
    let seeds = seeds::sample(surface, &features, params)?;
    let seeds_s = started.elapsed().as_secs_f64();
    observer.seeds(None, &seeds.positions, surface.frame());

    // 2. To a centroidal Voronoi tessellation of the solid.
    observer.stage(Stage::Relax { iterations: params.iterations });
    let mut relaxation = Relaxation::new(surface, &features, params, seeds)?;
    let mut stopped = relaxation.run(params.iterations * 2 / 3, observer)?;
    if params.boundary == Boundary::Conform && stopped != Stopped::Caller && params.iterations > 0 {
        stopped = refine::follow_surface(&mut relaxation, surface, params, observer)?;
    }
    if stopped != Stopped::Caller {
        let before_last = params.iterations * 9 / 10;
        stopped = relaxation.run(before_last.saturating_sub(relaxation.iterations()), observer)?;
    }

    // 3. More seeds where a valid mesh needs them, before the last iterations; what these break is mended once more.
    observer.stage(Stage::Extract);
    let started = Instant::now();
    let moved_s = relaxation.moving_time();
    let mut inside = refine::until_valid(&mut relaxation, surface, params, observer, stopped == Stopped::Caller)?;
    if stopped == Stopped::Iterations && relaxation.iterations() < params.iterations {
        stopped = relaxation.run(params.iterations - relaxation.iterations(), observer)?;
        inside = refine::until_valid(&mut relaxation, surface, params, observer, stopped == Stopped::Caller)?;
    }
    observer.triangulation(relaxation.delaunay(), surface.frame());

    // 4. The restricted Delaunay tets and their boundary.
    let kinds = relaxation.seeds().kinds();
    let sampling = Sampling::new(relaxation.delaunay(), &kinds, surface, relaxation.seeds().spacing);
    let mut mesh = extract::mesh(&sampling, &inside);
    mesh.check().map_err(Error::Broken)?;
    let extract_s = started.elapsed().as_secs_f64();

    // 5. Slivers out.
    let started = Instant::now();
    if params.improve {
        observer.stage(Stage::Improve);
        mesh.improved = improve::improve(&mut mesh, relaxation.seeds(), (surface, &features), params, observer);
    }
    let improve_s = started.elapsed().as_secs_f64();

    mesh.stopped = describe(stopped, params);
    (mesh.steps, mesh.times) = relaxation.into_record();
    mesh.times.seeds = seeds_s;
    mesh.times.extract = extract_s - (mesh.times.update + mesh.times.centroids - moved_s);
    mesh.times.improve = improve_s;
    Ok(mesh)
}

fn describe(stopped: Stopped, params: &Params) -> String {
    match stopped {
        Stopped::Iterations => "as many as were asked for".to_string(),
        Stopped::Tolerance => format!("the energy changed by less than {:e} of itself", params.tolerance),
        Stopped::Caller => "stopped by the caller".to_string(),
    }
}
