//! What a ray meets where single precision cannot tell.
//!
//! The kernels of [`crate::accel`] know by how much a distance may be wrong. Where that matters, as
//! it does for surfaces that touch each other or nearly so, and near the ends of a ray, all that
//! the ray meets is looked at once more in double precision:
//!
//! - A surface *touches* a point if it is as near as coordinates of that size are rounded.
//! - Of surfaces that lie in one plane and overlap, **the one that comes first in the scene lies
//!   outermost on its front side**, as if there were room in between. So there is an order in which
//!   any ray goes through them, the same from both ends, and all methods see the same: from in
//!   front, the first one in the file.
//! - A ray that starts on one of them meets those that follow in this order, and no others; one
//!   that ends there has met those that come before. Nothing is jumped over, and nothing is met
//!   that lies behind.
//! - Another surface that touches the start is met if it reaches to the side to which the ray
//!   leaves, and does not lie behind. So the neighbours of a triangle in a mesh do not shadow it,
//!   and walls that meet in a corner do not let light through.

use glam::DVec3;

use crate::accel::Hit;
use crate::math::Ray;
use crate::math::ray::triangle_of;
use crate::math::triangle::{ExactTriangle, rounding_of};
use crate::scene::Scene;
use crate::scene::geometry::Geometry;

/// A triangle of the scene in double precision.
#[derive(Clone, Copy, Debug)]
struct Triangle {
    index: u32,
    shape: ExactTriangle,
}

/// Something that a ray meets.
#[derive(Clone, Copy, Debug)]
struct Crossing {
    t: f64,
    hit: Hit,
    triangle: Triangle,
}

/// A ray in double precision, with the triangles that it starts and ends on.
struct Line<'a> {
    geometry: &'a Geometry,
    origin: DVec3,
    direction: DVec3,
    t_max: f64,
    leaves: Option<Triangle>,
    aims_at: Option<Triangle>,
}

/// The first surface that the ray meets of those that stop it.
pub(super) fn first(scene: &Scene, ray: &Ray, stops: impl FnMut(&Hit) -> bool) -> Option<Hit> {
    met(scene, ray, true, stops).first().map(|c| c.hit)
}

/// All surfaces that the ray meets, in order.
pub(super) fn all(scene: &Scene, ray: &Ray) -> Vec<Hit> {
    let all = met(scene, ray, false, |_| true);
    let exact = |c: Crossing| Hit {
        t: (c.t as f32).max(f32::MIN_POSITIVE),
        ..c.hit
    };
    all.into_iter().map(exact).collect()
}

/// Share of light that gets along a ray to its end, from what each surface lets through.
pub(super) fn transmittance(scene: &Scene, ray: &Ray, through: impl Fn(&Hit) -> f32) -> f32 {
    let mut line = None;
    let mut share = 1.0;
    scene.bvh().crossings(ray, &mut |crossing| {
        let (t, slack) = (crossing.hit.t, crossing.slack);
        let is_between = t - slack > 0.0 && t + slack < ray.t_max();
        let mut is_met = || {
            let line = line.get_or_insert_with(|| Line::new(scene.geometry(), ray));
            line.meet(&crossing.hit).is_some()
        };
        if is_between || is_met() {
            share *= through(&crossing.hit);
        }
        if share > 0.0 {
            ray.t_max()
        } else {
            f32::NEG_INFINITY
        }
    });
    share
}

/// What the ray meets of that which stops it, in order; as far as the first one only, if `ends`
/// there.
fn met(scene: &Scene, ray: &Ray, ends: bool, mut stops: impl FnMut(&Hit) -> bool) -> Vec<Crossing> {
    let line = Line::new(scene.geometry(), ray);
    let mut met = Vec::new();
    scene.bvh().crossings(ray, &mut |crossing| {
        let found = line.meet(&crossing.hit).filter(|c| stops(&c.hit));
        let Some(found) = found else {
            return ray.t_max();
        };
        met.push(found);
        if ends {
            (found.t as f32).max(crossing.hit.t) + crossing.slack
        } else {
            ray.t_max()
        }
    });
    line.sort(&mut met);
    met
}

impl<'a> Line<'a> {
    fn new(geometry: &'a Geometry, ray: &Ray) -> Self {
        let triangle = |index| triangle_of(index).map(|index| Triangle::new(geometry, index));
        Self {
            geometry,
            origin: ray.origin().as_dvec3(),
            direction: ray.direction().as_dvec3(),
            t_max: f64::from(ray.t_max()),
            leaves: triangle(ray.leaves()),
            aims_at: triangle(ray.aims_at()),
        }
    }

    fn at(&self, t: f64) -> DVec3 {
        self.origin + self.direction * t
    }

    /// The crossing with a triangle that the ray may meet; `None` if it does not.
    fn meet(&self, hit: &Hit) -> Option<Crossing> {
        let triangle = Triangle::new(self.geometry, hit.triangle);
        let shape = &triangle.shape;
        let slope = shape.normal.dot(self.direction);
        let exact = -shape.height(self.origin) / slope;
        let mut t = if exact.is_finite() {
            exact
        } else {
            f64::from(hit.t)
        };
        let start = self
            .leaves
            .filter(|_| shape.touches(self.origin, self.origin));
        match start {
            Some(start) if !start.is_before(&triangle, self.origin, self.direction) => return None,
            Some(_) => t = t.max(0.0),
            None if t > 0.0 => (),
            None => return None,
        }
        if t >= self.t_max && !self.aims_at.is_some_and(|_| self.touches_end(&triangle)) {
            return None;
        }
        if let Some(end) = self.aims_at.filter(|_| self.touches_end(&triangle))
            && !end.is_before(&triangle, self.at(self.t_max), -self.direction)
        {
            return None;
        }
        let hit = Hit {
            t: hit.t.max(f32::MIN_POSITIVE),
            ..*hit
        };
        Some(Crossing { t, hit, triangle })
    }

    /// True if a triangle touches the end of the ray, which is as exact as both ends are.
    fn touches_end(&self, triangle: &Triangle) -> bool {
        let end = self.at(self.t_max);
        end.is_finite() && triangle.shape.touches(end, self.origin)
    }

    /// Puts crossings into the order in which the ray comes through them.
    fn sort(&self, met: &mut [Crossing]) {
        met.sort_unstable_by(|a, b| {
            a.t.total_cmp(&b.t)
                .then(a.hit.triangle.cmp(&b.hit.triangle))
        });
        for i in 1..met.len() {
            let mut j = i;
            while j > 0 && self.swaps(&met[j - 1], &met[j]) {
                met.swap(j - 1, j);
                j -= 1;
            }
        }
    }

    /// True if the second of two crossings comes before the first, since their triangles lie in one
    /// plane.
    fn swaps(&self, first: &Crossing, second: &Crossing) -> bool {
        let (a, b) = (&first.triangle, &second.triangle);
        let point = self.at(first.t);
        b.shape.touches(point, point)
            && a.is_flush_with(b)
            && b.rank(self.direction) < a.rank(self.direction)
    }
}

impl Triangle {
    fn new(geometry: &Geometry, index: u32) -> Self {
        Self {
            index,
            shape: ExactTriangle::new(&geometry.facet(index).corners),
        }
    }

    /// True if both lie in one plane and overlap.
    fn is_flush_with(&self, other: &Self) -> bool {
        self.is_coplanar_with(other) && self.shape.overlaps(&other.shape)
    }

    /// True if both lie in one plane.
    fn is_coplanar_with(&self, other: &Self) -> bool {
        self.shape.lies_in(&other.shape) || other.shape.lies_in(&self.shape)
    }

    /// True if a ray that leaves this triangle at a point comes to another one that touches the
    /// point.
    fn is_before(&self, other: &Self, point: DVec3, direction: DVec3) -> bool {
        let (shape, others) = (&self.shape, &other.shape);
        if self.is_coplanar_with(other) {
            return shape.overlaps(others) && self.rank(direction) < other.rank(direction);
        }
        let side = shape.normal.dot(direction).signum();
        let reaches = |c: &DVec3| side * shape.height(*c) > rounding_of(*c).max(rounding_of(point));
        let towards = others.normal.dot(direction) * others.height(point);
        others.corners.iter().any(reaches) && towards <= 0.0
    }

    /// Its place among triangles in one plane, for a ray: those that it meets from the front, the
    /// first in the scene first, then those that it meets from behind, the first last.
    fn rank(&self, direction: DVec3) -> i64 {
        let index = i64::from(self.index);
        if self.shape.normal.dot(direction) < 0.0 {
            index
        } else {
            2 * i64::from(u32::MAX) - index
        }
    }
}
