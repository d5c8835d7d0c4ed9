//! Paths as lines: the camera's part, the light's part, and how they were joined.

use std::f32::consts::TAU;

use egui::{Color32, Painter, Pos2, Rect, Shape, Stroke, Vec2};
use glam::Vec3;
use neumann_core::endpoint::Camera;
use neumann_core::film::Joint;
use neumann_core::render::{Job, Replayed};
use neumann_core::transport::{PathVertex, VertexKind};
use neumann_picture::sheet;

use crate::display::image_area::Placement;
use crate::theme::Palette;

/// Two hues that those who see no red, no green or no blue tell apart (M. Okabe, K. Ito, Color
/// Universal Design, 2008), a lighter and a darker one of each.
const EYE: [Color32; 2] = [
    Color32::from_rgb(86, 180, 233),
    Color32::from_rgb(0, 114, 178),
];
const LIGHT: [Color32; 2] = [
    Color32::from_rgb(240, 170, 20),
    Color32::from_rgb(213, 94, 0),
];
const RADIUS: f32 = 4.0;
/// Halvings that find where a segment meets the plane of the eye.
const N_HALVINGS: u32 = 16;

/// Where a point of the scene is seen on the screen; `None` where it is behind the eye.
pub(super) type Through<'a> = dyn Fn(Vec3) -> Option<Pos2> + 'a;

/// As the camera of a job sees it, whose film stands at `rect`.
pub(super) fn through_camera(job: &Job, rect: Rect) -> Box<Through<'static>> {
    let settings = &job.settings;
    let size = Vec2::new(settings.width as f32, settings.height as f32);
    let camera = Camera::new(&settings.camera, settings.width, settings.height);
    Box::new(move |at| {
        let raster = camera.seen_at(at)?;
        Some(rect.min + Vec2::new(raster.x, raster.y) / size * rect.size())
    })
}

/// The hue of what comes from the eye, and of what comes from the light.
pub(super) fn hues(p: &Palette) -> [Color32; 2] {
    let i = usize::from(*p == Palette::of_theme(false));
    [EYE[i], LIGHT[i]]
}

/// What paths are drawn as, to be painted on the screen or on a sheet.
pub(super) struct Marks {
    all: Vec<Mark>,
    /// Nothing is drawn outside of this.
    clip: Rect,
    /// From the eye, from the light.
    hues: [Color32; 2],
    outline: Color32,
    text: Color32,
}

enum Mark {
    Line {
        ends: [Pos2; 2],
        stroke: Stroke,
        is_dashed: bool,
    },
    Disk {
        center: Pos2,
        radius: f32,
        color: Color32,
    },
    Ring {
        center: Pos2,
        radius: f32,
        stroke: Stroke,
    },
}

/// Lengths of the dashes of a connection, and of the gaps between them.
const DASHES: [f32; 2] = [5.0, 4.0];
/// Corners of a ring on a sheet.
const N_CORNERS: usize = 24;

/// A path in the scene: both parts, each from its own end.
struct Lines {
    parts: [Vec<Vec3>; 2],
}

impl Lines {
    /// Light from far away is drawn from a distance of `reach`.
    fn of(path: &Replayed, reach: f32) -> Self {
        let mut parts = [&path.camera, &path.light].map(|part| {
            let near = part.iter().filter(|v| v.kind != VertexKind::FarLight);
            near.map(|v| v.position).collect::<Vec<_>>()
        });
        let far = |part: &[PathVertex]| {
            let mut all = part.iter();
            all.find(|v| v.kind == VertexKind::FarLight)
                .map(|v| v.position)
        };
        if let (Some(direction), Some(last)) = (far(&path.camera), parts[0].last().copied()) {
            parts[0].push(last + direction * reach);
        }
        let next = parts[1].first().or(parts[0].last()).copied();
        if let (Some(direction), Some(next)) = (far(&path.light), next) {
            parts[1].insert(0, next + direction * reach);
        }
        Self { parts }
    }

    /// The vertices from the eye on, each with the part that it is of.
    fn vertices(&self, is_merge: bool) -> Vec<(Vec3, usize)> {
        let [eye, light] = &self.parts;
        let of_eye = eye.iter().map(|at| (*at, 0));
        let of_light = light
            .iter()
            .rev()
            .skip(usize::from(is_merge))
            .map(|at| (*at, 1));
        of_eye.chain(of_light).collect()
    }
}

impl Marks {
    /// Nothing yet, of what lies within a rectangle.
    pub(super) fn new(clip: Rect, p: &Palette) -> Self {
        Self {
            all: Vec::new(),
            clip,
            hues: hues(p),
            outline: p.ground,
            text: p.text,
        }
    }

    /// A path as lines, as opaque as `strength` says. A connection is dashed; a merge is a ring
    /// about the two ends that were taken for one point.
    pub(super) fn add_path(
        &mut self,
        through: &Through<'_>,
        path: &Replayed,
        reach: f32,
        strength: f32,
    ) {
        let lines = Lines::of(path, reach);
        let width = if strength >= 1.0 { 2.0 } else { 1.0 };
        let strokes = self
            .hues
            .map(|hue| Stroke::new(width, hue.gamma_multiply(strength)));
        for (part, stroke) in lines.parts.iter().zip(strokes) {
            for pair in part.windows(2) {
                if let Some(ends) = self.on_screen(through, [pair[0], pair[1]]) {
                    if strength >= 1.0 {
                        let under = self.outline.gamma_multiply(0.7);
                        self.add_line(ends, Stroke::new(width + 2.0, under), false);
                    }
                    self.add_line(ends, stroke, false);
                }
            }
        }
        let [eye, light] = &lines.parts;
        let (Some(a), Some(b)) = (eye.last(), light.last()) else {
            return;
        };
        match path.contribution.strategy.joint {
            Joint::Merge => {
                if let (Some(center), Some(other)) = (through(*a), through(*b)) {
                    let radius = center.distance(other).max(RADIUS) + 2.0;
                    self.add_ring(center, radius, strokes[1]);
                }
            }
            Joint::Connect => {
                if let Some(ends) = self.on_screen(through, [*a, *b]) {
                    self.add_line(ends, strokes[1], true);
                }
            }
            Joint::Hit => {}
        }
    }

    /// The part of a segment that is within what is painted: near the plane of the eye a segment is
    /// as good as endless, and a dashed one has as many dashes.
    fn on_screen(&self, through: &Through<'_>, ends: [Vec3; 2]) -> Option<[Pos2; 2]> {
        within(self.clip.expand(2.0), visible(through, ends)?)
    }

    /// The vertices of a path as circles: those from the eye full, those from the light open. The
    /// one that is looked at has a ring.
    pub(super) fn add_vertices(
        &mut self,
        through: &Through<'_>,
        path: &Replayed,
        reach: f32,
        looked_at: usize,
    ) {
        let is_merge = path.contribution.strategy.joint == Joint::Merge;
        let vertices = Lines::of(path, reach).vertices(is_merge);
        for (i, (at, part)) in vertices.into_iter().enumerate() {
            let Some(at) = through(at).filter(|at| self.clip.contains(*at)) else {
                continue;
            };
            let hue = self.hues[part];
            self.add_disk(at, RADIUS + 1.5, self.outline);
            if part == 0 {
                self.add_disk(at, RADIUS, hue);
            } else {
                self.add_ring(at, RADIUS - 0.5, Stroke::new(1.5, hue));
            }
            if i == looked_at {
                self.add_ring(at, RADIUS + 4.0, Stroke::new(1.5, self.text));
            }
        }
    }

    /// The eye of the camera, as a full circle.
    pub(super) fn add_eye(&mut self, at: Pos2) {
        self.add_disk(at, RADIUS + 1.0, self.outline);
        self.add_disk(at, RADIUS - 0.5, self.hues[0]);
    }

    fn add_line(&mut self, ends: [Pos2; 2], stroke: Stroke, is_dashed: bool) {
        self.all.push(Mark::Line {
            ends,
            stroke,
            is_dashed,
        });
    }

    fn add_disk(&mut self, center: Pos2, radius: f32, color: Color32) {
        self.all.push(Mark::Disk {
            center,
            radius,
            color,
        });
    }

    fn add_ring(&mut self, center: Pos2, radius: f32, stroke: Stroke) {
        self.all.push(Mark::Ring {
            center,
            radius,
            stroke,
        });
    }

    /// Paints them on the screen.
    pub(super) fn paint(&self, painter: &Painter) {
        let [dash, gap] = DASHES;
        for mark in &self.all {
            match mark {
                Mark::Line {
                    ends,
                    stroke,
                    is_dashed: true,
                } => painter.extend(Shape::dashed_line(ends, *stroke, dash, gap)),
                Mark::Line { ends, stroke, .. } => {
                    painter.line_segment(*ends, *stroke);
                }
                Mark::Disk {
                    center,
                    radius,
                    color,
                } => {
                    painter.circle_filled(*center, *radius, *color);
                }
                Mark::Ring {
                    center,
                    radius,
                    stroke,
                } => {
                    painter.circle_stroke(*center, *radius, *stroke);
                }
            }
        }
    }

    /// The same as lines on a sheet.
    pub(super) fn strokes(&self) -> Vec<sheet::Stroke> {
        let mut strokes = Vec::new();
        let mut add = |ends: [Pos2; 2], width: f32, color: Color32| {
            let [r, g, b, a] = color.to_srgba_unmultiplied();
            strokes.push(sheet::Stroke {
                ends: ends.map(|at| [at.x, at.y]),
                width,
                colour: [r, g, b],
                opacity: f32::from(a) / 255.0,
            });
        };
        for mark in &self.all {
            match *mark {
                Mark::Line {
                    ends: [from, to],
                    stroke,
                    is_dashed,
                } => {
                    let length = from.distance(to);
                    let [dash, gap] = if is_dashed { DASHES } else { [length, 1.0] };
                    let n = (length / (dash + gap)).ceil().max(1.0) as usize;
                    let at = |along: f32| from.lerp(to, (along / length.max(1e-6)).min(1.0));
                    for i in 0..n {
                        let start = i as f32 * (dash + gap);
                        add([at(start), at(start + dash)], stroke.width, stroke.color);
                    }
                }
                Mark::Disk {
                    center,
                    radius,
                    color,
                } => add([center, center], 2.0 * radius, color),
                Mark::Ring {
                    center,
                    radius,
                    stroke,
                } => {
                    let corner = |i: usize| {
                        center + radius * Vec2::angled(i as f32 * TAU / N_CORNERS as f32)
                    };
                    for i in 0..N_CORNERS {
                        add([corner(i), corner(i + 1)], stroke.width, stroke.color);
                    }
                }
            }
        }
        strokes
    }
}

/// The part of a segment that is before the eye.
fn visible(through: &Through<'_>, [a, b]: [Vec3; 2]) -> Option<[Pos2; 2]> {
    match (through(a), through(b)) {
        (Some(a), Some(b)) => Some([a, b]),
        (None, None) => None,
        (Some(seen), None) => Some([seen, edge(through, a, b)?]),
        (None, Some(seen)) => Some([edge(through, b, a)?, seen]),
    }
}

/// Where the way from a point that is seen to one that is not leaves what is seen.
fn edge(through: &Through<'_>, mut seen: Vec3, mut unseen: Vec3) -> Option<Pos2> {
    for _ in 0..N_HALVINGS {
        let middle = 0.5 * (seen + unseen);
        if through(middle).is_some() {
            seen = middle;
        } else {
            unseen = middle;
        }
    }
    through(seen)
}

/// The part of a segment that is within a rectangle (Y.-D. Liang, B. A. Barsky, A New Concept and
/// Method for Line Clipping, ACM TOG 3(1), 1984).
fn within(rect: Rect, [a, b]: [Pos2; 2]) -> Option<[Pos2; 2]> {
    let along = b - a;
    let mut shares = [0.0f32, 1.0];
    for (from, way, low, high) in [
        (a.x, along.x, rect.left(), rect.right()),
        (a.y, along.y, rect.top(), rect.bottom()),
    ] {
        if way == 0.0 {
            if from < low || from > high {
                return None;
            }
            continue;
        }
        let [first, last] = [(low - from) / way, (high - from) / way];
        shares[0] = shares[0].max(first.min(last));
        shares[1] = shares[1].min(first.max(last));
    }
    let [first, last] = shares;
    (first <= last).then(|| [a + along * first, a + along * last])
}

/// A frame around a pixel, large enough to be seen.
pub(super) fn mark_pixel(painter: &Painter, placement: &Placement, pixel: [usize; 2], p: &Palette) {
    let film = placement.film;
    let size = film.size() / Vec2::new(placement.size.0 as f32, placement.size.1 as f32);
    let corner = film.min + Vec2::new(pixel[0] as f32, pixel[1] as f32) * size;
    let pixel = Rect::from_min_size(corner, size);
    let frame = Rect::from_center_size(pixel.center(), size.max(Vec2::splat(9.0)));
    let painter = painter.with_clip_rect(placement.visible.expand(6.0));
    let outside = egui::StrokeKind::Outside;
    painter.rect_stroke(frame.expand(1.0), 0, Stroke::new(1.0, p.ground), outside);
    painter.rect_stroke(frame, 0, Stroke::new(1.0, p.strong), outside);
    for [x, y] in [[-1.0, 0.0], [1.0, 0.0], [0.0, -1.0], [0.0, 1.0]] {
        let way = Vec2::new(x, y);
        let half = 0.5 * frame.size();
        let from = frame.center() + way * (half + Vec2::splat(2.0));
        let to = frame.center() + way * (half + Vec2::splat(8.0));
        painter.line_segment([from, to], Stroke::new(3.0, p.ground));
        painter.line_segment([from, to], Stroke::new(1.0, p.strong));
    }
}

#[cfg(test)]
mod tests {
    use egui::{Rect, pos2};
    use glam::Vec3;

    use super::{visible, within};

    #[test]
    fn segments_are_cut_at_the_edge_of_the_picture() {
        let rect = Rect::from_min_max(pos2(0.0, 0.0), pos2(100.0, 50.0));
        let cut = |a: (f32, f32), b: (f32, f32)| within(rect, [a.into(), b.into()]);
        let inside = [pos2(10.0, 10.0), pos2(90.0, 20.0)];
        assert_eq!(within(rect, inside), Some(inside));
        let across = cut((-1e9, 25.0), (1e9, 25.0)).unwrap();
        assert!((across[0].x).abs() < 200.0 && (across[1].x - 100.0).abs() < 200.0);
        let down = cut((50.0, -50.0), (50.0, 25.0));
        assert_eq!(down, Some([pos2(50.0, 0.0), pos2(50.0, 25.0)]));
        assert_eq!(cut((-10.0, 0.0), (-10.0, 50.0)), None);
        assert_eq!(cut((-10.0, 40.0), (10.0, 80.0)), None);
    }

    #[test]
    fn segments_are_cut_where_they_pass_the_eye() {
        // An eye at the origin that looks along z.
        let through = |at: Vec3| (at.z > 0.0).then(|| pos2(at.x / at.z, at.y / at.z));
        let before = [Vec3::new(0.0, 0.0, 1.0), Vec3::new(1.0, 0.0, 1.0)];
        assert_eq!(
            visible(&through, before),
            Some([pos2(0.0, 0.0), pos2(1.0, 0.0)])
        );
        let behind = [Vec3::new(0.0, 0.0, -1.0), Vec3::new(1.0, 0.0, -1.0)];
        assert_eq!(visible(&through, behind), None);
        let across = [Vec3::new(1.0, 0.0, 1.0), Vec3::new(1.0, 0.0, -1.0)];
        let [seen, cut] = visible(&through, across).unwrap();
        assert!(seen == pos2(1.0, 0.0) && cut.x > 1000.0, "{cut:?}");
    }
}
