//! The window's surface on the graphics device.

use std::sync::Arc;
use std::time::{Duration, Instant};

use egui::{Context, FullOutput};
use egui_wgpu::{Renderer, RendererOptions, ScreenDescriptor, wgpu};
use wgpu::CurrentSurfaceTexture as Current;
use winit::event_loop::ActiveEventLoop;
use winit::window::Window;

use crate::display::FilmGpu;
use crate::options::ViewError;
use crate::theme::Palette;

/// Device, surface and the renderer of the interface.
pub(crate) struct Surface {
    surface: wgpu::Surface<'static>,
    device: wgpu::Device,
    queue: wgpu::Queue,
    config: wgpu::SurfaceConfiguration,
    renderer: Renderer,
    /// The adapter is a program, not a processor.
    pub(crate) is_software: bool,
    /// The window can no longer be drawn to.
    pub(crate) is_gone: bool,
}

impl Surface {
    /// Finds an adapter for the window and a device on it.
    pub(crate) fn new(
        event_loop: &ActiveEventLoop,
        window: Arc<Window>,
    ) -> Result<Self, ViewError> {
        let none = |e: &dyn std::fmt::Display| {
            ViewError::NoAdapter(e.to_string().lines().next().unwrap_or_default().to_owned())
        };
        let size = window.inner_size();
        let descriptor = wgpu::InstanceDescriptor::new_with_display_handle_from_env(Box::new(
            event_loop.owned_display_handle(),
        ));
        let instance = wgpu::Instance::new(descriptor);
        let surface = instance.create_surface(window).map_err(|e| none(&e))?;
        let options = wgpu::RequestAdapterOptions {
            compatible_surface: Some(&surface),
            ..Default::default()
        };
        let adapter =
            pollster::block_on(instance.request_adapter(&options)).map_err(|e| none(&e))?;
        let (device, queue) = device(&adapter)?;
        let formats = surface.get_capabilities(&adapter).formats;
        let format = egui_wgpu::preferred_framebuffer_format(&formats).map_err(|e| none(&e))?;
        let (width, height) = (size.width.max(1), size.height.max(1));
        let mut config = surface
            .get_default_config(&adapter, width, height)
            .ok_or_else(|| ViewError::NoAdapter("it cannot draw to this window".to_owned()))?;
        config.format = format;
        surface.configure(&device, &config);
        let mut renderer = Renderer::new(
            &device,
            format,
            RendererOptions {
                // Greys are flat; there is nothing to dither.
                dithering: false,
                ..RendererOptions::default()
            },
        );
        let film = FilmGpu::new(&device, &queue, format);
        renderer.callback_resources.insert(film);
        Ok(Self {
            surface,
            device,
            queue,
            config,
            renderer,
            is_software: adapter.get_info().device_type == wgpu::DeviceType::Cpu,
            is_gone: false,
        })
    }

    /// Longest edge of a texture.
    pub(crate) fn max_texture_side(&self) -> usize {
        self.device.limits().max_texture_dimension_2d as usize
    }

    /// Follows the window's size; a minimised window has none.
    pub(crate) fn resize(&mut self, width: u32, height: u32) {
        if width > 0 && height > 0 {
            (self.config.width, self.config.height) = (width, height);
            self.configure();
        }
    }

    /// Makes the surface anew, which only a window that was destroyed refuses.
    fn configure(&mut self) {
        let scope = self.device.push_error_scope(wgpu::ErrorFilter::Validation);
        self.surface.configure(&self.device, &self.config);
        self.is_gone |= pollster::block_on(scope.pop()).is_some();
    }

    /// Draws and presents; yields the time spent before the device's own work began.
    pub(crate) fn present(
        &mut self,
        window: &Window,
        ctx: &Context,
        mut output: FullOutput,
    ) -> Option<Duration> {
        let frame = match self.surface.get_current_texture() {
            Current::Success(frame) | Current::Suboptimal(frame) => Some(frame),
            Current::Outdated | Current::Lost => {
                self.configure();
                window.request_redraw();
                None
            }
            Current::Timeout | Current::Occluded | Current::Validation => None,
        };
        let start = Instant::now();
        let delta = &mut output.textures_delta;
        update_textures(&mut self.renderer, &self.device, &self.queue, delta);
        let mut prepared = None;
        if let Some(frame) = frame {
            let screen = ScreenDescriptor {
                size_in_pixels: [self.config.width, self.config.height],
                pixels_per_point: output.pixels_per_point,
            };
            let shapes = std::mem::take(&mut output.shapes);
            let jobs = ctx.tessellate(shapes, output.pixels_per_point);
            let mut encoder = self.device.create_command_encoder(&Default::default());
            let mut buffers = self.renderer.update_buffers(
                &self.device,
                &self.queue,
                &mut encoder,
                &jobs,
                &screen,
            );
            let view = frame.texture.create_view(&Default::default());
            let ground = Palette::of_theme(ctx.theme() == egui::Theme::Dark).panel;
            draw(&mut encoder, &self.renderer, &view, &jobs, &screen, ground);
            buffers.push(encoder.finish());
            prepared = Some(start.elapsed());
            self.queue.submit(buffers);
            window.pre_present_notify();
            self.queue.present(frame);
        }
        free_textures(&mut self.renderer, &mut output.textures_delta);
        prepared
    }
}

/// Takes over the textures that egui made or changed.
#[allow(clippy::iter_over_hash_type, reason = "no texture depends on another")]
pub(crate) fn update_textures(
    renderer: &mut Renderer,
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    delta: &mut egui::TexturesDelta,
) {
    for (id, changes) in delta.set.drain() {
        for change in changes {
            renderer.update_texture(device, queue, id, &change);
        }
    }
}

/// Gives up the textures that egui no longer needs; only after the frame has been submitted.
#[allow(clippy::iter_over_hash_type, reason = "no texture depends on another")]
pub(crate) fn free_textures(renderer: &mut Renderer, delta: &mut egui::TexturesDelta) {
    for id in delta.free.drain() {
        renderer.free_texture(&id);
    }
}

/// A device on an adapter, with no more than what any adapter can do but its largest textures.
pub(crate) fn device(adapter: &wgpu::Adapter) -> Result<(wgpu::Device, wgpu::Queue), ViewError> {
    let descriptor = wgpu::DeviceDescriptor {
        required_limits: wgpu::Limits::downlevel_defaults().using_resolution(adapter.limits()),
        ..Default::default()
    };
    pollster::block_on(adapter.request_device(&descriptor))
        .map_err(|e| ViewError::NoAdapter(e.to_string()))
}

/// One pass over the interface's shapes, on a target cleared to `ground`.
pub(crate) fn draw(
    encoder: &mut wgpu::CommandEncoder,
    renderer: &Renderer,
    view: &wgpu::TextureView,
    jobs: &[egui::ClippedPrimitive],
    screen: &ScreenDescriptor,
    ground: egui::Color32,
) {
    let channel = |code: u8| f64::from(code) / 255.0;
    let pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("window"),
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations {
                load: wgpu::LoadOp::Clear(wgpu::Color {
                    r: channel(ground.r()),
                    g: channel(ground.g()),
                    b: channel(ground.b()),
                    a: 1.0,
                }),
                store: wgpu::StoreOp::Store,
            },
        })],
        ..Default::default()
    });
    renderer.render(&mut pass.forget_lifetime(), jobs, screen);
}
