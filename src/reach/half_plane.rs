//! Half-planes of the horizontal plane and the polygons they bound.

use nalgebra::Vector2;

/// The points p (m) with n·p < c.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfPlane {
    /// Outward normal n.
    pub normal: Vector2<f64>,
    /// Bound c, in units of n times m.
    pub bound: f64,
}

impl HalfPlane {
    /// c - n·p: positive inside.
    pub fn slack(&self, point: &Vector2<f64>) -> f64 {
        self.bound - self.normal.dot(point)
    }

    /// How far a ray from `origin` along `direction` stays inside, in lengths of `direction`; infinite if it never leaves,
    /// zero if `origin` is not inside.
    pub fn ray(&self, origin: &Vector2<f64>, direction: &Vector2<f64>) -> f64 {
        let (slack, approach) = (self.slack(origin), self.normal.dot(direction));
        if slack <= 0.0 {
            0.0
        } else if approach <= 0.0 {
            f64::INFINITY
        } else {
            slack / approach
        }
    }
}

/// Vertices of the intersection, in order round it; empty if there is none. The half-planes must bound a set that lies within
/// `extent` m of the origin.
pub fn polygon(half_planes: &[HalfPlane], extent: f64) -> Vec<Vector2<f64>> {
    let e = extent;
    let mut vertices =
        vec![Vector2::new(e, e), Vector2::new(-e, e), Vector2::new(-e, -e), Vector2::new(e, -e)];
    for half_plane in half_planes {
        vertices = clip(&vertices, half_plane);
    }
    vertices
}

/// Sutherland and Hodgman's clipping of a convex polygon at one half-plane.
fn clip(vertices: &[Vector2<f64>], half_plane: &HalfPlane) -> Vec<Vector2<f64>> {
    let mut inside = Vec::with_capacity(vertices.len() + 1);
    for (k, point) in vertices.iter().enumerate() {
        let next = vertices[(k + 1) % vertices.len()];
        let (here, there) = (half_plane.slack(point), half_plane.slack(&next));
        if here >= 0.0 {
            inside.push(*point);
        }
        if (here > 0.0 && there < 0.0) || (here < 0.0 && there > 0.0) {
            inside.push(point + (next - point) * (here / (here - there)));
        }
    }
    inside
}
