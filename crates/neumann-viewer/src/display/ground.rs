//! The ground that a picture lies on: one grey, without the texture that the toolkit's own shapes
//! read at each pixel. On a software adapter that is a quarter of a frame's time.

use egui::{Color32, PaintCallbackInfo, Rect, Ui};
use egui_wgpu::{CallbackResources, CallbackTrait, ScreenDescriptor, wgpu};

use super::gpu::{FilmGpu, covering_pipeline};

/// Fills `rect` with a grey.
pub fn fill(ui: &Ui, rect: Rect, grey: Color32) {
    let ground = Ground { code: grey.r() };
    let callback = egui_wgpu::Callback::new_paint_callback(rect, ground);
    ui.painter().add(callback);
}

struct Ground {
    /// sRGB code of all three channels.
    code: u8,
}

/// A pipeline for each grey that was asked for.
pub(super) struct GroundGpu {
    shader: wgpu::ShaderModule,
    format: wgpu::TextureFormat,
    pipelines: Vec<(u8, wgpu::RenderPipeline)>,
}

impl GroundGpu {
    pub(super) fn new(device: &wgpu::Device, format: wgpu::TextureFormat) -> Self {
        Self {
            shader: device.create_shader_module(wgpu::include_wgsl!("ground.wgsl")),
            format,
            pipelines: Vec::new(),
        }
    }

    fn prepare(&mut self, device: &wgpu::Device, code: u8) {
        if self.pipelines.iter().any(|(made, _)| *made == code) {
            return;
        }
        let coded = f64::from(code) / 255.0;
        let grey = if self.format.is_srgb() {
            decoded(coded)
        } else {
            coded
        };
        let options = wgpu::PipelineCompilationOptions {
            constants: &[("GREY", grey)],
            ..Default::default()
        };
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("ground"),
            bind_group_layouts: &[],
            immediate_size: 0,
        });
        let pipeline = covering_pipeline(device, &self.shader, &layout, self.format, options);
        self.pipelines.push((code, pipeline));
    }
}

fn decoded(code: f64) -> f64 {
    if code <= 0.04045 {
        code / 12.92
    } else {
        ((code + 0.055) / 1.055).powf(2.4)
    }
}

impl CallbackTrait for Ground {
    fn prepare(
        &self,
        device: &wgpu::Device,
        _: &wgpu::Queue,
        _: &ScreenDescriptor,
        _: &mut wgpu::CommandEncoder,
        resources: &mut CallbackResources,
    ) -> Vec<wgpu::CommandBuffer> {
        if let Some(gpu) = resources.get_mut::<FilmGpu>() {
            gpu.ground.prepare(device, self.code);
        }
        Vec::new()
    }

    fn paint(
        &self,
        _: PaintCallbackInfo,
        pass: &mut wgpu::RenderPass<'static>,
        resources: &CallbackResources,
    ) {
        let Some(gpu) = resources.get::<FilmGpu>() else {
            return;
        };
        let mut pipelines = gpu.ground.pipelines.iter();
        if let Some((_, pipeline)) = pipelines.find(|(code, _)| *code == self.code) {
            pass.set_pipeline(pipeline);
            pass.draw(0..3, 0..1);
        }
    }
}
