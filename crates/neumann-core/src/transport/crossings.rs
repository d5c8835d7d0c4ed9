//! What a ray meets where single precision cannot tell.
//!
//! The kernels of [`crate::accel`] know by how much a distance may be wrong. Where that matters, as
//! it does for surfaces that
//! touch each other or nearly so, and near the ends of a ray, all that the ray meets is looked at
//! once more in double precision:
//!
//! - A surface *touches* a point if it is as near as coordinates of that size are rounded.
//! - Of surfaces that lie in one plane and overlap, **the one that comes first in the scene lies outermost on its front side**, as if
//!   there were room in between. So there is an order in which any ray goes through them, the same from both ends, and all methods see
//!   the same: from in front, the first one in the file.
//! - A ray that starts on one of them meets those that follow in this order, and no others; one that ends there has met those that
//!   come before. Nothing is jumped over, and nothing is met that lies behind.
//! - Another surface that touches the start is met if it reaches to the side to which the ray leaves, and does not lie behind. So the
//!   neighbours of a triangle in a mesh do not shadow it, and walls that meet in a corner do not let light through.

use glam::{DVec2, DVec3};

use crate::accel::Hit;
use crate::math::Ray;
use crate::math::ray::triangle_of;
use crate::scene::Scene;
use crate::scene::geometry::Geometry;

/// A point touches a surface if that is no farther away than this share of its largest coordinate:
/// four times what it is rounded by.
const TOUCH: f64 = 1.0 / 2_097_152.0;

/// A triangle in double precision.
#[derive(Clone, Copy, Debug)]
struct Triangle {
    index: u32,
    corners: [DVec3; 3],
    /// Unit, towards the front.
    normal: DVec3,
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
        let slope = triangle.normal.dot(self.direction);
        let exact = -triangle.height(self.origin) / slope;
        let mut t = if exact.is_finite() {
            exact
        } else {
            f64::from(hit.t)
        };
        let start = self
            .leaves
            .filter(|_| triangle.touches(self.origin, self.origin));
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
        end.is_finite() && triangle.touches(end, self.origin)
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
        b.touches(point, point)
            && a.is_flush_with(b)
            && b.rank(self.direction) < a.rank(self.direction)
    }
}

impl Triangle {
    fn new(geometry: &Geometry, index: u32) -> Self {
        let corners = geometry.facet(index).corners.map(glam::Vec3::as_dvec3);
        let [a, b, c] = corners;
        Self {
            index,
            corners,
            normal: (b - a).cross(c - a).normalize_or_zero(),
        }
    }

    /// How far a point is above its plane.
    fn height(&self, point: DVec3) -> f64 {
        self.normal.dot(point - self.corners[0])
    }

    /// True if a point, which is rounded as another one is or as its own coordinates are, may lie
    /// in its plane.
    fn touches(&self, point: DVec3, rounded_as: DVec3) -> bool {
        let rounding = rounding_of(point).max(rounding_of(rounded_as));
        self.height(point).abs() <= rounding
    }

    /// True if it lies in the plane of another one.
    fn lies_in(&self, other: &Self) -> bool {
        self.corners.iter().all(|c| other.touches(*c, *c))
    }

    /// True if both lie in one plane and overlap.
    fn is_flush_with(&self, other: &Self) -> bool {
        (self.lies_in(other) || other.lies_in(self)) && self.overlaps(other)
    }

    /// True if a ray that leaves this triangle at a point comes to another one that touches the
    /// point.
    fn is_before(&self, other: &Self, point: DVec3, direction: DVec3) -> bool {
        if self.lies_in(other) || other.lies_in(self) {
            return self.overlaps(other) && self.rank(direction) < other.rank(direction);
        }
        let side = self.normal.dot(direction).signum();
        let reaches = |c: &DVec3| side * self.height(*c) > rounding_of(*c).max(rounding_of(point));
        let towards = other.normal.dot(direction) * other.height(point);
        other.corners.iter().any(reaches) && towards <= 0.0
    }

    /// Its place among triangles in one plane, for a ray: those that it meets from the front, the
    /// first in the scene first, then those
    /// that it meets from behind, the first last.
    fn rank(&self, direction: DVec3) -> i64 {
        let index = i64::from(self.index);
        if self.normal.dot(direction) < 0.0 {
            index
        } else {
            2 * i64::from(u32::MAX) - index
        }
    }

    /// True if it overlaps another triangle of the same plane, by more than rounding: no edge of
    /// either keeps them apart.
    fn overlaps(&self, other: &Self) -> bool {
        let axis = self.normal.abs();
        let flat = |p: DVec3| {
            if axis.x >= axis.y && axis.x >= axis.z {
                DVec2::new(p.y, p.z)
            } else if axis.y >= axis.z {
                DVec2::new(p.z, p.x)
            } else {
                DVec2::new(p.x, p.y)
            }
        };
        let rounding = |t: &Self| t.corners.iter().fold(0.0, |r, c| rounding_of(*c).max(r));
        let rounding = rounding(self).min(rounding(other));
        let [a, b] = [self, other].map(|t| t.corners.map(flat));
        !is_kept_apart(&a, &b, rounding) && !is_kept_apart(&b, &a, rounding)
    }
}

/// True if an edge of one triangle has another triangle on its far side.
fn is_kept_apart(one: &[DVec2; 3], other: &[DVec2; 3], rounding: f64) -> bool {
    (0..3).any(|i| {
        let (from, to, inside) = (one[i], one[(i + 1) % 3], one[(i + 2) % 3]);
        let along = (to - from).normalize_or_zero();
        let side = along.perp_dot(inside - from).signum();
        let within = |p: &DVec2| side * along.perp_dot(*p - from) > rounding;
        !other.iter().any(within)
    })
}

/// By how much a point with such coordinates may be off a surface that it was meant to lie on.
fn rounding_of(point: DVec3) -> f64 {
    TOUCH * point.abs().max_element()
}
