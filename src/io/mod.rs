//! Files: surfaces in, meshes out. Whole files or none.
