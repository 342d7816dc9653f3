//! Rays, boxes and spheres.

pub(super) type Vec3 = [f64; 3];

pub(super) fn add(a: Vec3, b: Vec3) -> Vec3 {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

pub(super) fn sub(a: Vec3, b: Vec3) -> Vec3 {
    add(a, scale(b, -1.0))
}

pub(super) fn scale(a: Vec3, k: f64) -> Vec3 {
    a.map(|v| v * k)
}

pub(super) fn dot(a: Vec3, b: Vec3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn unit(a: Vec3) -> Vec3 {
    scale(a, 1.0 / dot(a, a).sqrt())
}

#[derive(Debug, Clone, Copy)]
pub(super) enum Shape {
    /// Between two opposite corners.
    Block(Vec3, Vec3),
    Sphere(Vec3, f64),
}

/// Rays start at this distance from a surface, so that rounding does not make them hit the same surface
/// again.
const NEAR: f64 = 1e-6;

impl Shape {
    /// Distance along the ray to the first hit, in lengths of `direction`, and the normal at that point. A
    /// block cannot be hit from inside.
    pub(super) fn hit(&self, origin: Vec3, direction: Vec3) -> Option<(f64, Vec3)> {
        match *self {
            Self::Block(low, high) => {
                let (enter, leave, axis) = crossing(low, high, origin, direction);
                let mut normal = [0.0; 3];
                normal[axis] = -direction[axis].signum();
                (enter > NEAR && enter <= leave).then_some((enter, normal))
            }
            Self::Sphere(centre, radius) => {
                let from = sub(origin, centre);
                let (a, b) = (dot(direction, direction), dot(from, direction));
                let root = b * b - a * (dot(from, from) - radius * radius);
                let t = (-b - root.max(0.0).sqrt()) / a;
                let normal = || scale(add(from, scale(direction, t)), 1.0 / radius);
                (root > 0.0 && t > NEAR).then(|| (t, normal()))
            }
        }
    }
}

/// Whether a viewing ray intersects a block, or starts inside it.
pub(super) fn meets(low: Vec3, high: Vec3, origin: Vec3, direction: Vec3) -> bool {
    let (enter, leave, _) = crossing(low, high, origin, direction);
    enter.max(0.0) <= leave
}

/// Where a ray enters and leaves a block, in lengths of `direction`, and the axis across which it enters.
fn crossing(low: Vec3, high: Vec3, origin: Vec3, direction: Vec3) -> (f64, f64, usize) {
    let (mut enter, mut leave, mut axis) = (f64::NEG_INFINITY, f64::INFINITY, 0);
    for i in 0..3 {
        let inverse = 1.0 / direction[i];
        let (a, b) = ((low[i] - origin[i]) * inverse, (high[i] - origin[i]) * inverse);
        let (near, far) = (a.min(b), a.max(b));
        if near > enter {
            (enter, axis) = (near, i);
        }
        leave = leave.min(far);
    }
    (enter, leave, axis)
}
