//! Gmsh's format 4.1, binary or text: C. Geuzaine, J.-F. Remacle, *Gmsh: a 3-D finite element mesh generator with
//! built-in pre- and post-processing facilities*, International Journal for Numerical Methods in Engineering 79(11), 2009,
//! doi 10.1002/nme.2579.
//!
//! A volume entity and a physical group for each region, a surface entity and a physical group for each patch. Nodes of
//! the boundary belong to the surface with the least number that they are on, others to their volume.

use std::io::{self, Write};

use glam::DVec3;

use super::{MeshData, distinct};
use crate::geometry::bounding_box::BoundingBox;
use crate::io::format::Encoding;

/// Gmsh's numbers of triangles and tets, of the first and of the second order.
const TRIANGLES: [i32; 2] = [2, 9];
const TETS: [i32; 2] = [4, 11];

/// Gmsh has the middles of edges 23 and 13 the other way round.
const LAST: [usize; 2] = [8, 9];

/// Numbers in the encoding of the file.
struct Numbers<'a, W> {
    out: &'a mut W,
    binary: bool,
    begun: bool,
}

impl<W: Write> Numbers<'_, W> {
    fn text(&mut self, text: &str) -> io::Result<()> {
        self.out.write_all(text.as_bytes())
    }

    fn put(&mut self, bytes: &[u8], text: impl std::fmt::Display) -> io::Result<()> {
        if self.binary {
            return self.out.write_all(bytes);
        }
        let blank = if std::mem::replace(&mut self.begun, true) { " " } else { "" };
        write!(self.out, "{blank}{text}")
    }

    fn int(&mut self, x: i32) -> io::Result<()> {
        self.put(&x.to_le_bytes(), x)
    }

    fn size(&mut self, x: usize) -> io::Result<()> {
        self.put(&(x as u64).to_le_bytes(), x)
    }

    fn point(&mut self, p: DVec3) -> io::Result<()> {
        p.to_array().iter().try_for_each(|x| self.put(&x.to_le_bytes(), format_args!("{x:?}")))
    }

    /// Ends a line of text.
    fn end(&mut self) -> io::Result<()> {
        self.begun = false;
        if self.binary { Ok(()) } else { self.out.write_all(b"\n") }
    }

    /// Ends a section; a binary one needs the end of a line too.
    fn close(&mut self, section: &str) -> io::Result<()> {
        let begin = if self.binary { "\n" } else { "" };
        writeln!(self.out, "{begin}$End{section}")
    }
}

/// The parts of the model that nodes and elements belong to.
struct Entities {
    patches: Vec<u32>,
    regions: Vec<u32>,
    /// For each node its place in the list of patches, then regions.
    of_node: Vec<u32>,
}

impl Entities {
    fn of(data: &MeshData) -> Entities {
        let mesh = data.mesh;
        let patches = distinct(mesh.boundary.iter().map(|b| b.patch));
        let regions = distinct(mesh.regions.iter().copied());
        let mut of_node = vec![u32::MAX; data.node_count()];
        let mut nodes = Vec::new();
        let mut claim = |nodes: &[u32], entity: usize| {
            nodes.iter().for_each(|&v| of_node[v as usize] = of_node[v as usize].min(entity as u32));
        };
        for (f, triangle) in mesh.boundary.iter().enumerate() {
            data.triangle_nodes(f, &mut nodes);
            claim(&nodes, place(&patches, triangle.patch));
        }
        for (t, &region) in mesh.regions.iter().enumerate() {
            data.tet_nodes(t, &mut nodes);
            claim(&nodes, patches.len() + place(&regions, region));
        }
        Entities { patches, regions, of_node }
    }

    /// Dimension and number of each, in order.
    fn tags(&self) -> impl Iterator<Item = (i32, i32)> {
        let tag = |id: &u32| i32::try_from(i64::from(*id) + 1).expect("ids are checked: this is a bug in tetcvt");
        self.patches.iter().map(move |p| (2, tag(p))).chain(self.regions.iter().map(move |r| (3, tag(r))))
    }

    /// For each the box around its nodes.
    fn boxes(&self, data: &MeshData) -> Vec<BoundingBox> {
        let none = BoundingBox { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };
        let mut boxes = vec![none; self.patches.len() + self.regions.len()];
        let mut grow = |place: usize, p: DVec3| {
            let b = &mut boxes[place];
            (b.min, b.max) = (b.min.min(p), b.max.max(p));
        };
        for b in &data.mesh.boundary {
            let corners = b.vertices.map(|v| data.mesh.points[v as usize]);
            corners.iter().for_each(|&p| grow(place(&self.patches, b.patch), p));
        }
        for (t, &region) in data.mesh.regions.iter().enumerate() {
            data.mesh.corners(t).iter().for_each(|&p| grow(self.patches.len() + place(&self.regions, region), p));
        }
        boxes
    }
}

fn place(ids: &[u32], id: u32) -> usize {
    ids.binary_search(&id).expect("every id is listed: this is a bug in tetcvt")
}

pub(super) fn write(data: &MeshData, out: &mut impl Write) -> io::Result<()> {
    let binary = data.encoding == Encoding::Binary;
    let mut out = Numbers { out, binary, begun: false };
    out.text(&format!("$MeshFormat\n4.1 {} 8\n", u8::from(binary)))?;
    if binary {
        // Tells the order of the bytes.
        out.int(1)?;
    }
    out.close("MeshFormat")?;
    let entities = Entities::of(data);
    write_names(&entities, &mut out)?;
    write_entities(data, &entities, &mut out)?;
    write_nodes(data, &entities, &mut out)?;
    write_elements(data, &entities, &mut out)
}

fn write_names<W: Write>(entities: &Entities, out: &mut Numbers<W>) -> io::Result<()> {
    out.text(&format!("$PhysicalNames\n{}\n", entities.patches.len() + entities.regions.len()))?;
    for (dimension, tag) in entities.tags() {
        let name = if dimension == 2 { "patch" } else { "region" };
        out.text(&format!("{dimension} {tag} \"{name}_{}\"\n", tag - 1))?;
    }
    // Text in binary files too.
    out.text("$EndPhysicalNames\n")
}

fn write_entities<W: Write>(data: &MeshData, entities: &Entities, out: &mut Numbers<W>) -> io::Result<()> {
    out.text("$Entities\n")?;
    for count in [0, 0, entities.patches.len(), entities.regions.len()] {
        out.size(count)?;
    }
    out.end()?;
    for ((dimension, tag), bounds) in entities.tags().zip(entities.boxes(data)) {
        out.int(tag)?;
        out.point(bounds.min)?;
        out.point(bounds.max)?;
        // Its physical group.
        out.size(1)?;
        out.int(tag)?;
        // What bounds it.
        let bounding = if dimension == 2 { Vec::new() } else { surfaces_of(data, tag) };
        out.size(bounding.len())?;
        bounding.iter().try_for_each(|&surface| out.int(surface))?;
        out.end()?;
    }
    out.close("Entities")
}

/// The surfaces that bound a volume.
fn surfaces_of(data: &MeshData, volume: i32) -> Vec<i32> {
    let bounds = |region: i64| region + 1 == i64::from(volume);
    let sides = data.mesh.boundary.iter();
    let own = sides.filter(|b| bounds(b.region_inside.into()) || bounds(b.region_outside.into()));
    distinct(own.map(|b| b.patch)).iter().map(|&p| p as i32 + 1).collect()
}

fn write_nodes<W: Write>(data: &MeshData, entities: &Entities, out: &mut Numbers<W>) -> io::Result<()> {
    let points: Vec<DVec3> = data.nodes().collect();
    let mut order: Vec<u32> = (0..points.len() as u32).collect();
    order.sort_by_key(|&v| entities.of_node[v as usize]);
    let tags: Vec<(i32, i32)> = entities.tags().collect();
    let blocks = || order.chunk_by(|&a, &b| entities.of_node[a as usize] == entities.of_node[b as usize]);
    out.text("$Nodes\n")?;
    for count in [blocks().count(), points.len(), 1, points.len()] {
        out.size(count)?;
    }
    out.end()?;
    for block in blocks() {
        let (dimension, tag) = tags[entities.of_node[block[0] as usize] as usize];
        out.int(dimension)?;
        out.int(tag)?;
        // Not parametric.
        out.int(0)?;
        out.size(block.len())?;
        out.end()?;
        for &v in block {
            out.size(v as usize + 1)?;
            out.end()?;
        }
        for &v in block {
            out.point(points[v as usize])?;
            out.end()?;
        }
    }
    out.close("Nodes")
}

fn write_elements<W: Write>(data: &MeshData, entities: &Entities, out: &mut Numbers<W>) -> io::Result<()> {
    let mesh = data.mesh;
    let order = usize::from(data.second_order.is_some());
    let (triangles, tets) = (mesh.boundary.len(), mesh.tets.len());
    out.text("$Elements\n")?;
    for count in [entities.patches.len() + entities.regions.len(), triangles + tets, 1, triangles + tets] {
        out.size(count)?;
    }
    out.end()?;
    let mut nodes = Vec::new();
    let mut number = 0;
    for (dimension, tag) in entities.tags() {
        let is_in = |id: u32| i64::from(id) + 1 == i64::from(tag);
        let own: Vec<usize> = match dimension {
            2 => (0..triangles).filter(|&f| is_in(mesh.boundary[f].patch)).collect(),
            _ => (0..tets).filter(|&t| is_in(mesh.regions[t])).collect(),
        };
        out.int(dimension)?;
        out.int(tag)?;
        out.int(if dimension == 2 { TRIANGLES[order] } else { TETS[order] })?;
        out.size(own.len())?;
        out.end()?;
        for i in own {
            if dimension == 2 {
                data.triangle_nodes(i, &mut nodes);
            } else {
                data.tet_nodes(i, &mut nodes);
                if order == 1 {
                    nodes.swap(LAST[0], LAST[1]);
                }
            }
            number += 1;
            out.size(number)?;
            nodes.iter().try_for_each(|&v| out.size(v as usize + 1))?;
            out.end()?;
        }
    }
    out.close("Elements")
}
