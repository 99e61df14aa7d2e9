//! temp
use glam::DVec3;
pub struct Shape { pub points: Vec<DVec3>, pub triangles: Vec<[u32;3]> }
pub fn cuboid(a: DVec3, b: DVec3) -> Shape {
    let points = (0..8).map(|i| DVec3::new(if i&1==0 {a.x} else {b.x}, if i&2==0 {a.y} else {b.y}, if i&4==0 {a.z} else {b.z})).collect();
    let q: [[u32;4];6] = [[0,2,3,1],[4,5,7,6],[0,1,5,4],[2,6,7,3],[0,4,6,2],[1,3,7,5]];
    Shape { points, triangles: q.iter().flat_map(|q| [[q[0],q[1],q[2]],[q[0],q[2],q[3]]]).collect() }
}
pub fn torus(r: f64, s: f64, n: usize, m: usize) -> Shape {
    let mut points = vec![]; let mut triangles = vec![];
    for i in 0..n { for j in 0..m {
        let (u,v)=(i as f64/n as f64*std::f64::consts::TAU, j as f64/m as f64*std::f64::consts::TAU);
        points.push(DVec3::new((r+s*v.cos())*u.cos(),(r+s*v.cos())*u.sin(),s*v.sin()));
        let id=|i:usize,j:usize| ((i%n)*m+j%m) as u32;
        let (a,b,c,d)=(id(i,j),id(i+1,j),id(i+1,j+1),id(i,j+1));
        triangles.push([a,b,c]); triangles.push([a,c,d]);
    }}
    Shape{points,triangles}
}
pub fn all() -> Vec<(&'static str, Shape)> { vec![("cube", cuboid(DVec3::ZERO, DVec3::ONE)), ("torus", torus(1.0,0.4,48,24)), ("plate", cuboid(DVec3::ZERO, DVec3::new(1.0,0.8,0.01)))] }
