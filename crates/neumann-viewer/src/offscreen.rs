//! The window drawn to a file, without a display.

use std::time::{Duration, Instant};

use egui::{Context, FullOutput, RawInput, Rect, Theme, ViewportId, pos2};
use egui_wgpu::{Renderer, RendererOptions, ScreenDescriptor, wgpu};
use neumann_picture::png_file::{Pixels8, write_png};

use crate::app::App;
use crate::display::FilmGpu;
use crate::options::{Screenshot, ViewError, ViewOptions};
use crate::render_link::RenderLink;
use crate::surface::{device, draw, free_textures, update_textures};
use crate::theme::Palette;

/// A frame whose scene or iterations have not come by then is drawn as it is.
const PATIENCE: Duration = Duration::from_secs(600);

/// Draws the window that the options describe to the file that they name.
///
/// # Errors
/// If there is no graphics adapter, the scene cannot be opened, or the file not be written.
pub fn run(options: ViewOptions) -> Result<(), ViewError> {
    let Some(shot) = options.screenshot.clone() else {
        return Err(ViewError::Other("no screenshot was asked for".to_owned()));
    };
    let mut canvas = Canvas::new(shot.size)?;
    let largest_side = canvas.device.limits().max_texture_dimension_2d as usize;
    options.check_sizes(largest_side)?;
    let link = RenderLink::live(options.threads, || {}).map_err(ViewError::Other)?;
    let mut app = App::new(link, options, || {});
    app.largest_side = largest_side;
    app.open_first_scene();
    let pixels = canvas.draw_when_ready(&mut app, &shot)?;
    write_png(&shot.path, &pixels).map_err(|e| ViewError::Other(e.to_string()))
}

/// A device without a window.
struct Canvas {
    device: wgpu::Device,
    queue: wgpu::Queue,
    renderer: Renderer,
    size: (u32, u32),
}

impl Canvas {
    fn new(size: (u32, u32)) -> Result<Self, ViewError> {
        let descriptor = wgpu::InstanceDescriptor::new_without_display_handle_from_env();
        let instance = wgpu::Instance::new(descriptor);
        let adapter = pollster::block_on(instance.request_adapter(&Default::default()))
            .map_err(|e| ViewError::NoAdapter(e.to_string()))?;
        let (device, queue) = device(&adapter)?;
        let mut renderer = Renderer::new(&device, FORMAT, RendererOptions::PREDICTABLE);
        let film = FilmGpu::new(&device, &queue, FORMAT);
        renderer.callback_resources.insert(film);
        Ok(Self {
            device,
            queue,
            renderer,
            size,
        })
    }

    fn draw_when_ready(&mut self, app: &mut App, shot: &Screenshot) -> Result<Pixels8, ViewError> {
        let ctx = Context::default();
        crate::theme::install(&ctx);
        crate::theme::set_cleared(&ctx);
        ctx.set_theme(if shot.light_theme {
            Theme::Light
        } else {
            Theme::Dark
        });
        let start = Instant::now();
        loop {
            let output = self.lay_out(&ctx, app);
            self.take_textures(output);
            let wanted = shot.after_iterations.max(1);
            let is_there = match app.viewing.views.n_iterations() {
                Some(n) => n >= wanted,
                None => {
                    app.session.is_current()
                        && app.session.picture.divisor == 1
                        && app.session.picture.stats.n_iterations >= wanted
                }
            };
            if is_there
                || (app.session.picture.is_there()
                    && app.session.picture.stats.is_done
                    && app.session.is_current())
            {
                break;
            }
            let is_hopeless = app.session.setup.open.is_none() && !app.is_loading();
            if is_hopeless {
                let text = app
                    .shell
                    .notices
                    .texts()
                    .next()
                    .unwrap_or("no scene")
                    .to_owned();
                return Err(ViewError::Other(text));
            }
            if start.elapsed() > PATIENCE {
                break;
            }
            std::thread::sleep(Duration::from_millis(10));
        }
        // What was laid out with the first sizes settles within a few frames.
        app.session.link.pause(true);
        for _ in 0..2 {
            let output = self.lay_out(&ctx, app);
            self.take_textures(output);
        }
        app.session.link.pause(false);
        let output = self.lay_out(&ctx, app);
        self.render(&ctx, output)
    }

    fn lay_out(&self, ctx: &Context, app: &mut App) -> FullOutput {
        let size = pos2(self.size.0 as f32, self.size.1 as f32);
        let mut input = RawInput {
            screen_rect: Some(Rect::from_min_max(pos2(0.0, 0.0), size)),
            focused: true,
            max_texture_side: Some(self.device.limits().max_texture_dimension_2d as usize),
            ..RawInput::default()
        };
        let viewport = input.viewports.entry(ViewportId::ROOT).or_default();
        viewport.native_pixels_per_point = Some(1.0);
        ctx.run_ui(input, |ui| app.ui(ui))
    }

    fn take_textures(&mut self, mut output: FullOutput) {
        let delta = &mut output.textures_delta;
        update_textures(&mut self.renderer, &self.device, &self.queue, delta);
        free_textures(&mut self.renderer, delta);
    }

    fn render(&mut self, ctx: &Context, mut output: FullOutput) -> Result<Pixels8, ViewError> {
        let (width, height) = self.size;
        let screen = ScreenDescriptor {
            size_in_pixels: [width, height],
            pixels_per_point: output.pixels_per_point,
        };
        let shapes = std::mem::take(&mut output.shapes);
        let jobs = ctx.tessellate(shapes, output.pixels_per_point);
        self.take_textures(output);
        let extent = wgpu::Extent3d {
            width,
            height,
            depth_or_array_layers: 1,
        };
        let texture = self.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("screenshot"),
            size: extent,
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: FORMAT,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        let row = (4 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("screenshot"),
            size: u64::from(row) * u64::from(height),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let mut encoder = self.device.create_command_encoder(&Default::default());
        let mut buffers =
            self.renderer
                .update_buffers(&self.device, &self.queue, &mut encoder, &jobs, &screen);
        let view = texture.create_view(&Default::default());
        let ground = Palette::of_theme(ctx.theme() == Theme::Dark).panel;
        draw(&mut encoder, &self.renderer, &view, &jobs, &screen, ground);
        encoder.copy_texture_to_buffer(
            texture.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &buffer,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(row),
                    rows_per_image: None,
                },
            },
            extent,
        );
        buffers.push(encoder.finish());
        self.queue.submit(buffers);
        self.read(&buffer, row as usize)
    }

    fn read(&self, buffer: &wgpu::Buffer, row: usize) -> Result<Pixels8, ViewError> {
        let other = |e: &dyn std::fmt::Display| ViewError::Other(e.to_string());
        let slice = buffer.slice(..);
        slice.map_async(wgpu::MapMode::Read, |_| {});
        self.device
            .poll(wgpu::PollType::wait_indefinitely())
            .map_err(|e| other(&e))?;
        let bytes = slice.get_mapped_range().map_err(|e| other(&e))?;
        let (width, height) = (self.size.0 as usize, self.size.1 as usize);
        let pixels = bytes
            .chunks(row)
            .flat_map(|row| row[..4 * width].chunks_exact(4))
            .map(|p| [p[0], p[1], p[2]])
            .collect();
        Ok(Pixels8 {
            width,
            height,
            pixels,
        })
    }
}

const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;
