//! The scene from another side, small, with the same paths: the picture's camera stays.

use std::collections::HashSet;
use std::f32::consts::FRAC_PI_2;
use std::sync::Arc;

use egui::{Painter, Rect, Role, Sense, Stroke, Ui, Vec2, WidgetInfo};
use glam::Vec3;
use neumann_core::endpoint::Camera;
use neumann_core::render::Job;
use neumann_core::scene::Scene;

use super::drawing::{Marks, Through};
use crate::theme::Palette;
use crate::views::turning;
use crate::widgets::focus_ring;

/// Triangles whose edges are drawn, at most.
const N_TRIANGLES: usize = 1500;
/// Distance of the eye, in radii of the scene.
const DISTANCE: f32 = 2.6;
/// A camera further away than this, in radii of the scene, is left out.
const FAR: f32 = 4.0;

/// From where the scene is looked at.
pub(super) struct Outside {
    /// Angles about the vertical and over the horizon, radians.
    yaw: f32,
    pitch: f32,
    /// In units of the distance that shows the whole scene.
    distance: f32,
    edges: Option<(Arc<Scene>, Vec<[Vec3; 2]>)>,
}

impl Default for Outside {
    fn default() -> Self {
        Self {
            yaw: 0.6,
            pitch: 0.35,
            distance: 1.0,
            edges: None,
        }
    }
}

/// Its width on a stage.
pub(super) fn width(stage: Rect) -> f32 {
    (0.3 * stage.width()).clamp(120.0, 220.0)
}

/// Its height on a stage.
pub(super) fn height(stage: Rect) -> f32 {
    0.72 * width(stage)
}

impl Outside {
    /// A drag turns the scene, the wheel goes nearer; arrows do while it has the keyboard.
    pub(super) fn take_pointer(&mut self, ui: &Ui, rect: Rect, scene: &Arc<Scene>) {
        let response = ui.interact(rect, ui.scope_id().with("outside"), Sense::click_and_drag());
        let name = "the scene from outside, with the paths";
        response.widget_info(|| WidgetInfo::labeled(Role::Image, true, name));
        let turn = turning::taken(ui, &response, rect);
        if response.hovered() {
            let wheel = ui.input(|input| input.smooth_scroll_delta().y);
            self.distance = (self.distance * (-0.002 * wheel).exp()).clamp(0.2, 4.0);
        }
        self.yaw += turn.x;
        self.pitch = (self.pitch + turn.y).clamp(-0.98 * FRAC_PI_2, 0.98 * FRAC_PI_2);
        let is_known = |(of, _): &(Arc<Scene>, _)| Arc::ptr_eq(of, scene);
        if !self.edges.as_ref().is_some_and(is_known) {
            self.edges = Some((Arc::clone(scene), edges(scene)));
        }
        focus_ring(ui, &response, rect.shrink(2.0), 4);
        response.on_hover_text("The scene from outside. Drag to turn it, wheel to go nearer.");
    }

    /// As it is seen from there, in `rect`.
    pub(super) fn through(&self, rect: Rect, job: &Job) -> Box<Through<'static>> {
        let (min, max) = job.scene.subject();
        let center = 0.5 * (min + max);
        let reach = (0.5 * min.distance(max)).max(1e-6);
        let (sin, cos) = self.yaw.sin_cos();
        let (up, along) = self.pitch.sin_cos();
        let back = Vec3::new(along * sin, up, along * cos);
        let right = Vec3::new(cos, 0.0, -sin);
        let above = back.cross(right);
        let settings = &job.settings;
        let camera = Camera::new(&settings.camera, settings.width, settings.height).position();
        // A camera that stands not too far outside is to be seen, too.
        let away = camera.distance(center) / reach;
        let radius = reach * if away < FAR { away.max(1.0) } else { 1.0 };
        let eye = center + back * (DISTANCE * self.distance * radius);
        let near = 0.01 * radius;
        // All of it fits the shorter side.
        let scale = 0.5 * rect.size().min_elem() * (DISTANCE * DISTANCE - 1.0).sqrt();
        Box::new(move |at| {
            let from = at - eye;
            let depth = -from.dot(back);
            let seen = Vec2::new(from.dot(right), -from.dot(above)) * (scale / depth);
            (depth > near).then(|| rect.center() + seen)
        })
    }

    /// The edges of its triangles.
    pub(super) fn draw_scene(&self, painter: &Painter, through: &Through<'_>, p: &Palette) {
        let stroke = Stroke::new(1.0, p.weak.gamma_multiply(0.35));
        for [a, b] in self.edges.iter().flat_map(|(_, edges)| edges) {
            if let (Some(a), Some(b)) = (through(*a), through(*b)) {
                painter.line_segment([a, b], stroke);
            }
        }
    }

    /// Where the picture's camera stands.
    pub(super) fn add_camera(&self, marks: &mut Marks, through: &Through<'_>, job: &Job) {
        let settings = &job.settings;
        let camera = Camera::new(&settings.camera, settings.width, settings.height);
        if let Some(at) = through(camera.position()) {
            marks.add_eye(at);
        }
    }
}

/// Edges of triangles, each once: those of the largest triangles, and evenly many of all others.
fn edges(scene: &Scene) -> Vec<[Vec3; 2]> {
    let geometry = scene.geometry();
    let facets = (0..geometry.n_triangles() as u32).map(|i| geometry.facet(i).corners);
    let mut triangles: Vec<_> = facets.collect();
    let area = |[a, b, c]: &[Vec3; 3]| (*b - *a).cross(*c - *a).length_squared();
    triangles.sort_by(|a, b| area(b).total_cmp(&area(a)));
    let n_large = triangles.len().min(N_TRIANGLES / 2);
    let (large, others) = triangles.split_at(n_large);
    let step = others.len().div_ceil(N_TRIANGLES - n_large).max(1);
    let mut seen = HashSet::new();
    let mut edges = Vec::new();
    for [a, b, c] in large.iter().chain(others.iter().step_by(step)) {
        for [from, to] in [[a, b], [b, c], [c, a]] {
            let mut ends = [from, to].map(|at| at.to_array().map(f32::to_bits));
            ends.sort_unstable();
            if seen.insert(ends) {
                edges.push([*from, *to]);
            }
        }
    }
    edges
}
