//! The input: a closed, oriented, outward triangle surface.

use glam::DVec3;

use crate::geometry::bounding_box::BoundingBox;
use crate::geometry::frame::Frame;
use crate::geometry::triangle;

pub mod box_tree;

mod crossings;

pub mod defects;

pub(crate) mod edges;

pub mod features;

pub mod imprint;

mod measures;

mod needles;

mod orient;

mod ray;

mod refined;

mod repair;

mod soup;

pub(crate) mod walk;

use box_tree::BoxTree;
use defects::{Defect, Marks};
use soup::Soup;

pub(crate) use soup::note_count;

/// A closed, edge- and vertex-manifold, consistently oriented surface that bounds a solid; it cannot be built with a
/// defect, nor one that crosses or touches itself. Its points are in the normalised frame, on its grid.
pub struct Surface {
    points: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    source: Vec<u32>,
    patch: Vec<u32>,
    shell: Vec<u32>,
    /// Edges that are creases whatever the angle, each with the lesser vertex first, in order.
    lines: Vec<[u32; 2]>,
    shells: Vec<Shell>,
    has_interfaces: bool,
    frame: Frame,
    twins: Vec<edges::EdgeId>,
    tree: BoxTree,
    notes: Vec<String>,
    volume: f64,
    area: f64,
    diagonal: f64,
}

/// How much of what is wrong is mended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mending {
    /// What leaves the shape as it is; the rest is refused.
    #[default]
    Exact,
    /// Also what changes the shape a little, within stated bounds: nearly equal vertices of open edges are welded,
    /// duplicate faces and hanging sheets dropped, parts that touch moved apart, small and nearly flat holes filled.
    Repair,
}

/// What shells inside others are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum Regions {
    /// By turns cavities and solids within these.
    #[default]
    Parity,
    /// Interfaces between two regions of one solid.
    Nested,
}

/// How triangles become a surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Treatment {
    /// How much of what is wrong is mended.
    pub mending: Mending,
    /// What shells inside others are.
    pub regions: Regions,
}

/// A connected piece of the surface. Those inside an even number of others face outward, the rest inward, whatever is
/// on their other side.
#[derive(Clone, Copy, Debug)]
struct Shell {
    /// The solid on the side behind it, by parity.
    solid: u32,
    /// How many others it lies inside.
    depth: u32,
    /// The regions behind and in front of it; -1 where there is none.
    regions: [i32; 2],
    /// Whether the solid is on both of its sides.
    is_interface: bool,
    /// What it encloses, in the frame.
    volume: f64,
}

impl Shell {
    /// The shells of an oriented soup as `regions` has them.
    fn all(shells: &orient::Shells, volumes: &[measures::Volume], regions: Regions) -> Vec<Shell> {
        (0..shells.solid.len())
            .map(|s| {
                let volume = volumes[s].signed.abs();
                let (solid, depth, around) = (shells.solid[s], shells.depth[s], shells.around[s]);
                let (regions, is_interface) = match (regions, around) {
                    (Regions::Parity, _) => ([solid as i32, -1], false),
                    // Region s is what shell s holds but the shells within it do not.
                    (Regions::Nested, None) => ([s as i32, -1], false),
                    (Regions::Nested, Some(o)) if depth % 2 == 0 => ([s as i32, o as i32], true),
                    (Regions::Nested, Some(o)) => ([o as i32, s as i32], true),
                };
                Shell { solid, depth, regions, is_interface, volume }
            })
            .collect()
    }
}

/// Triangles that have passed every check.
struct Sound {
    soup: Soup,
    shells: orient::Shells,
    tree: BoxTree,
    notes: Vec<String>,
}

impl Sound {
    /// Steps: 1. every edge has two triangles, every vertex one fan; 2. neighbours are turned alike; 3. triangles without
    /// area go; 4. shells are turned by how they nest; 5. nothing meets beyond common edges and vertices.
    fn make(mut soup: Soup, regions: Regions, marks: &mut Marks) -> Result<Sound, Defect> {
        let mut notes = vec![];
        // 1.
        let twin = edges::check(&soup, marks)?;
        // 2.
        let mut shell = orient::agree(&mut soup, &twin, &mut notes, marks)?;
        // 3.
        if needles::remove(&mut soup, &mut notes, marks)? {
            // Triangles have gone or changed: every check and the shells anew, with nothing left to mend.
            let twin = edges::check(&soup, marks)?;
            shell = orient::agree(&mut soup, &twin, &mut notes, marks)?;
        }
        // 4.
        let shells = orient::outward(&mut soup, shell, regions, &mut notes, marks)?;
        // 5.
        let tree = BoxTree::build(&soup.points, &soup.triangles);
        crossings::check(&soup, &tree, marks)?;
        Ok(Sound { soup, shells, tree, notes })
    }
}

impl Surface {
    /// Checks `triangles` over `points` (model units) and makes them a surface. `source[t]` and `patch[t]` say where
    /// triangle `t` comes from: the index of its face in the input, and the id of its patch.
    ///
    /// What can be mended without guessing a shape is mended, with a note: vertices that are equal or that no face uses,
    /// triangles without area, faces turned against their neighbours, shells turned inside out. The rest is refused.
    /// A surface that crosses itself only with its triangles without area folded out is tried without their spikes.
    ///
    /// # Errors
    /// The [`Defect`], with how often it occurs and where first.
    ///
    /// # Panics
    /// Unless `source` and `patch` are as long as `triangles`.
    pub fn new(points: &[DVec3], triangles: &[[u32; 3]], source: &[u32], patch: &[u32]) -> Result<Surface, Defect> {
        Surface::build(points, triangles, [source, patch], Treatment::default(), &mut Marks::default())
    }

    /// The same with the choice of what is mended and of what nested shells are; the places of all that is wrong go to
    /// `marks`.
    ///
    /// # Errors
    /// The [`Defect`], with how often it occurs and where first.
    ///
    /// # Panics
    /// Unless `source` and `patch` are as long as `triangles`.
    pub fn build(
        points: &[DVec3],
        triangles: &[[u32; 3]],
        [source, patch]: [&[u32]; 2],
        treatment: Treatment,
        marks: &mut Marks,
    ) -> Result<Surface, Defect> {
        assert!(
            source.len() == triangles.len() && patch.len() == triangles.len(),
            "one source and one patch per triangle"
        );
        let mut notes = vec![];
        let (mut soup, frame) = Soup::new(points, triangles, source, patch, &mut notes)?;
        let Treatment { mending, regions } = treatment;
        if mending == Mending::Repair {
            repair::mend(&mut soup, &frame, &mut notes);
            marks.notes.clone_from(&notes);
        }
        let sound = match Sound::make(soup.clone(), regions, marks) {
            // What has no area may be a spike that overshoots: without it the surface may be sound.
            Err(defect @ Defect::SelfCrossing { .. }) => match needles::without_spikes(soup, &mut notes) {
                Some(soup) => {
                    let sound = Sound::make(soup, regions, &mut Marks::default()).map_err(|_| defect)?;
                    marks.list.clear();
                    sound
                }
                None => return Err(defect),
            },
            other => other?,
        };
        notes.extend_from_slice(&sound.notes);
        Ok(Surface::assemble(Sound { notes, ..sound }, regions, frame))
    }

    fn assemble(sound: Sound, regions: Regions, frame: Frame) -> Surface {
        let Sound { soup, shells: oriented, tree, notes } = sound;
        let Soup { points, triangles, source, patch, .. } = soup;
        let volumes = measures::shell_volumes(&points, &triangles, &oriented.of_triangle, oriented.solid.len());
        let shells = Shell::all(&oriented, &volumes, regions);
        let mut volume = measures::Sum::default();
        for (v, _) in volumes.iter().zip(&shells).filter(|(_, s)| !s.is_interface) {
            volume.add(v.signed);
        }
        Surface {
            volume: volume.value(),
            area: measures::area(&points, &triangles),
            diagonal: BoundingBox::of(&points).diagonal(),
            twins: edges::twins(&triangles),
            tree,
            points,
            triangles,
            source,
            patch,
            lines: Vec::new(),
            shell: oriented.of_triangle,
            has_interfaces: shells.iter().any(|s| s.is_interface),
            shells,
            frame,
            notes,
        }
    }

    /// Puts what a reader had to say before the other notes.
    pub(crate) fn with_notes(mut self, mut notes: Vec<String>) -> Surface {
        notes.append(&mut self.notes);
        self.notes = notes;
        self
    }

    /// Vertices, in the frame, on its grid.
    pub fn points(&self) -> &[DVec3] {
        &self.points
    }

    /// Triangles, counter-clockwise seen from outside the solid; those of interfaces, from their side that is inside an even
    /// number of shells.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// For each edge of the triangles, the other one over the same two vertices.
    pub(crate) fn twins(&self) -> &[edges::EdgeId] {
        &self.twins
    }

    /// The three corners of triangle `t`.
    pub fn corners(&self, t: u32) -> [DVec3; 3] {
        self.triangles[t as usize].map(|v| self.points[v as usize])
    }

    /// The outward normal of triangle `t`, twice its area long.
    pub fn normal2(&self, t: u32) -> DVec3 {
        let [a, b, c] = self.corners(t);
        triangle::normal2(a, b, c)
    }

    /// The triangle closest to the centroid of a facet, of those that face the same way where there are such nearby.
    pub fn facing(&self, corners: [DVec3; 3]) -> u32 {
        let [a, b, c] = corners;
        let (center, normal) = (triangle::centroid(a, b, c), triangle::normal2(a, b, c));
        let faces = |t: u32| self.normal2(t).dot(normal) > 0.0;
        let closest = self.tree.closest(center);
        if faces(closest.triangle) {
            return closest.triangle;
        }
        // In a thin wall the other sheet may be closer.
        let reach = corners.map(|p| p.distance(center)).into_iter().fold(0.0, f64::max);
        let mut best = (reach * reach, closest.triangle);
        self.tree.near_box(center - reach, center + reach, |t| {
            let d = triangle::closest_point(self.corners(t), center).distance_squared(center);
            if faces(t) && (d, t) < best {
                best = (d, t);
            }
        });
        best.1
    }

    /// For each triangle, the index of its face in the input, counted from 0.
    pub fn source(&self) -> &[u32] {
        &self.source
    }

    /// For each triangle, the id of its patch.
    pub fn patch(&self) -> &[u32] {
        &self.patch
    }

    /// Whether the input tells patches apart: whether there are two or more.
    pub fn has_patches(&self) -> bool {
        self.patch.windows(2).any(|p| p[0] != p[1])
    }

    /// For each triangle, the connected shell that it belongs to.
    pub fn shell(&self) -> &[u32] {
        &self.shell
    }

    /// The solid that a shell bounds by parity: an outermost shell and the cavities right inside it share one.
    pub fn solid_of_shell(&self, shell: u32) -> u32 {
        self.shells[shell as usize].solid
    }

    /// How many shells a shell lies inside.
    pub fn depth_of_shell(&self, shell: u32) -> u32 {
        self.shells[shell as usize].depth
    }

    /// What a shell encloses, other shells within it included, in the frame.
    pub fn volume_of_shell(&self, shell: u32) -> f64 {
        self.shells[shell as usize].volume
    }

    /// The regions behind and in front of a shell's triangles; -1 where there is none.
    pub fn regions_of_shell(&self, shell: u32) -> [i32; 2] {
        self.shells[shell as usize].regions
    }

    /// Whether some shell is an interface between two regions.
    pub fn has_interfaces(&self) -> bool {
        self.has_interfaces
    }

    /// Whether triangle `t` has the solid on both of its sides.
    pub fn is_interface(&self, t: u32) -> bool {
        self.has_interfaces && self.shells[self.shell[t as usize] as usize].is_interface
    }

    /// Whether the solid, with all of its regions, holds `p`; exact, as [`BoxTree::is_inside`], which tells on which side of
    /// the surface a point is.
    pub fn is_inside(&self, p: DVec3) -> bool {
        let mut inside = false;
        self.tree.crossed_upward(p, |t| inside ^= !self.is_interface(t));
        inside
    }

    /// Number of connected shells.
    pub fn shell_count(&self) -> usize {
        self.shells.len()
    }

    /// The way back to the model's coordinates.
    pub fn frame(&self) -> &Frame {
        &self.frame
    }

    /// Whether the edge between two vertices is on a line of the user's.
    pub(crate) fn is_on_line(&self, [a, b]: [u32; 2]) -> bool {
        self.lines.binary_search(&[a.min(b), a.max(b)]).is_ok()
    }

    /// The box tree over the triangles.
    pub fn tree(&self) -> &BoxTree {
        &self.tree
    }

    /// What was mended while the surface was made.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// Volume of the solid, all regions together, in the frame.
    pub fn volume(&self) -> f64 {
        self.volume
    }

    /// Area of the surface, interfaces included, in the frame.
    pub fn area(&self) -> f64 {
        self.area
    }

    /// Diagonal of the bounding box, in the frame.
    pub fn diagonal(&self) -> f64 {
        self.diagonal
    }

    /// Sum over all shells of the number of handles.
    pub fn genus(&self) -> usize {
        measures::genus(self.points.len(), self.triangles.len(), self.shell_count())
    }
}
