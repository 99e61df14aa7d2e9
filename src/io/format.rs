//! The formats that meshes and surfaces are written in, by the extension of the file's name.

use std::path::{Path, PathBuf};

/// A format of tetrahedral meshes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeshFormat {
    /// VTK's XML format, `.vtu`.
    Vtu,
    /// VTK's legacy format, `.vtk`.
    Vtk,
    /// Gmsh's format 4.1, `.msh`.
    Gmsh,
    /// Medit's text format, `.mesh`.
    Medit,
    /// An input file of Abaqus, `.inp`.
    Abaqus,
    /// TetGen's three files, `.node`, `.ele` and `.face`.
    TetGen,
}

/// A format of surfaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SurfaceFormat {
    /// VTK's XML format, `.vtp`.
    Vtp,
    /// VTK's legacy format, `.vtk`.
    Vtk,
    /// Wavefront OBJ, `.obj`.
    Obj,
    /// Stereolithography, `.stl`.
    Stl,
    /// The polygon file format, `.ply`.
    Ply,
}

/// How numbers are put into a file whose format has both ways.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Encoding {
    /// As they lie in memory.
    #[default]
    Binary,
    /// As the shortest decimals that read back to the same number.
    Text,
}

impl MeshFormat {
    /// What file names may end in.
    pub const KNOWN: &str = ".vtu, .vtk, .msh, .mesh, .inp, .node or .ele";

    /// The format of a mesh file, by its extension.
    pub fn of(path: &Path) -> Option<MeshFormat> {
        match extension(path)?.as_str() {
            "vtu" => Some(MeshFormat::Vtu),
            "vtk" => Some(MeshFormat::Vtk),
            "msh" => Some(MeshFormat::Gmsh),
            "mesh" => Some(MeshFormat::Medit),
            "inp" => Some(MeshFormat::Abaqus),
            "node" | "ele" => Some(MeshFormat::TetGen),
            _ => None,
        }
    }

    /// The files that make up the mesh `path`.
    pub fn files(self, path: &Path) -> Vec<PathBuf> {
        match self {
            MeshFormat::TetGen => ["node", "ele", "face"].map(|part| path.with_extension(part)).to_vec(),
            _ => vec![path.to_owned()],
        }
    }

    /// Whether the format has a binary and a text form.
    pub fn has_text(self) -> bool {
        self == MeshFormat::Gmsh
    }

    /// Whether the format takes tets with nodes in the middle of their edges.
    pub fn has_second_order(self) -> bool {
        !matches!(self, MeshFormat::Medit | MeshFormat::TetGen)
    }
}

impl SurfaceFormat {
    /// What file names may end in.
    pub const KNOWN: &str = ".vtp, .vtk, .obj, .stl or .ply";

    /// The format of a surface file, by its extension.
    pub fn of(path: &Path) -> Option<SurfaceFormat> {
        match extension(path)?.as_str() {
            "vtp" => Some(SurfaceFormat::Vtp),
            "vtk" => Some(SurfaceFormat::Vtk),
            "obj" => Some(SurfaceFormat::Obj),
            "stl" => Some(SurfaceFormat::Stl),
            "ply" => Some(SurfaceFormat::Ply),
            _ => None,
        }
    }

    /// Whether the format has a binary and a text form.
    pub fn has_text(self) -> bool {
        matches!(self, SurfaceFormat::Stl | SurfaceFormat::Ply)
    }
}

fn extension(path: &Path) -> Option<String> {
    Some(path.extension()?.to_str()?.to_ascii_lowercase())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_known_extension_has_its_format() {
        let named = |known: &str| -> Vec<PathBuf> {
            known
                .split([' ', ','])
                .filter(|word| word.starts_with('.'))
                .map(|e| PathBuf::from(format!("a{e}")))
                .collect()
        };
        let (meshes, surfaces) = (named(MeshFormat::KNOWN), named(SurfaceFormat::KNOWN));
        assert_eq!((meshes.len(), surfaces.len()), (7, 5));
        assert!(meshes.iter().all(|path| MeshFormat::of(path).is_some_and(|f| f.files(path).contains(path))));
        assert!(surfaces.iter().all(|path| SurfaceFormat::of(path).is_some()));
    }

    #[test]
    fn the_case_of_an_extension_does_not_matter_and_others_are_unknown() {
        assert_eq!(MeshFormat::of(Path::new("a/B.VTK")), Some(MeshFormat::Vtk));
        assert_eq!(SurfaceFormat::of(Path::new("b.surface.vtp")), Some(SurfaceFormat::Vtp));
        for name in ["a.vtp", "vtu", "a", "a.vtu.gz", "a.face", ""] {
            assert_eq!(MeshFormat::of(Path::new(name)), None, "{name}");
        }
        assert_eq!(SurfaceFormat::of(Path::new("a.vtu")), None);
    }
}
