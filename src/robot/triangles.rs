//! The paper's geometry: six cables between two equilateral triangles (paper/Fig. 1; `docs/paper.md` says which vertex is whose).

use nalgebra::{Vector2, Vector3};

/// Cables of the paper's robot.
pub const SIX: usize = 6;
/// sin 60°.
const S60: f64 = 0.866_025_403_784_438_6;

/// Unit vectors (cos, sin) at the azimuths of the base vertices of cables 1 to 6: 300, 300, 60, 60, 180, 180 degrees.
const BASE_AZIMUTH: [[f64; 2]; SIX] =
    [[0.5, -S60], [0.5, -S60], [0.5, S60], [0.5, S60], [-1.0, 0.0], [-1.0, 0.0]];

/// The same for the platform vertices: 240, 0, 0, 120, 120, 240 degrees.
const PLATFORM_AZIMUTH: [[f64; 2]; SIX] =
    [[-0.5, -S60], [1.0, 0.0], [1.0, 0.0], [-0.5, S60], [-0.5, S60], [-0.5, -S60]];

/// Outward normals of the facets of the static workspace: cable i is in tension when nᵢ·p < a/2.
/// Azimuths 150, 90, -90, 210, 30, -30 degrees.
pub const FACET_NORMALS: [Vector2<f64>; SIX] = [
    Vector2::new(-S60, 0.5),
    Vector2::new(0.0, 1.0),
    Vector2::new(0.0, -1.0),
    Vector2::new(-S60, -0.5),
    Vector2::new(S60, 0.5),
    Vector2::new(S60, -0.5),
];

/// Anchor (base frame) and attachment (platform frame) of each cable, m: two equilateral triangles of sides 2a and 2b, the second
/// turned by 180 degrees, in the plane of the centre of mass.
pub fn ends(a: f64, b: f64) -> [(Vector3<f64>, Vector3<f64>); SIX] {
    let vertex = |half_side: f64, [cos, sin]: [f64; 2]| {
        let radius = 2.0 * half_side / 3f64.sqrt();
        Vector3::new(radius * cos, radius * sin, 0.0)
    };
    std::array::from_fn(|i| (vertex(a, BASE_AZIMUTH[i]), vertex(b, PLATFORM_AZIMUTH[i])))
}
