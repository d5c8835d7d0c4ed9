//! The pictures on the graphics device, and the draw calls that show them.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use egui::PaintCallbackInfo;
use egui_wgpu::{CallbackResources, CallbackTrait, ScreenDescriptor, wgpu};
use neumann_picture::false_colour::{ColourMap, diverging};

use super::ground::GroundGpu;
use super::planes::{N_SLOTS, Planes, Slot};

/// The pictures, shared between the interface that fills them and the draw calls that upload them.
#[derive(Clone, Default)]
pub struct SharedPlanes(Arc<Mutex<Planes>>);

impl SharedPlanes {
    /// The pictures; never held across a frame.
    pub fn lock(&self) -> MutexGuard<'_, Planes> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// How a draw call shows its pictures: the shader's `Look`, field for field.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Look {
    /// Origin and size of what is shown of the left picture, texture coordinates.
    pub left: [f32; 4],
    /// The same of the right one.
    pub right: [f32; 4],
    /// Radiance per stored unit left and right (filled in on upload), exposure factor, place of the
    /// wipe.
    pub scale: [f32; 4],
    /// Base-2 logarithms of the ends of the false-colour range; difference at the end of its scale;
    /// unused.
    pub range: [f32; 4],
    /// Row of the colour map; the rest is unused.
    pub map: [i32; 4],
}

/// What a pipeline is made for: the shader's overrides.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Variant {
    /// Index of the tone curve.
    pub tone: usize,
    /// What is made of the pictures.
    pub mode: Mode,
    /// Left and right of a wipe are two pictures.
    pub is_wiping: bool,
    /// Pixels blend into each other.
    pub is_smooth: bool,
}

/// What is made of the pictures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mode {
    /// They are shown.
    #[default]
    Picture,
    /// Luminance as colours.
    FalseColour,
    /// The difference of two in luminance.
    Difference,
}

/// Shows one or two pictures in a rectangle.
pub struct Draw {
    /// Where the pictures are.
    pub planes: SharedPlanes,
    /// What is left of the wipe, or first of the difference.
    pub left: Slot,
    /// What is right of the wipe, or second of the difference.
    pub right: Slot,
    /// How.
    pub look: Look,
    /// By which pipeline.
    pub variant: Variant,
    /// Number of this draw call within the frame.
    pub index: usize,
}

/// Draw calls per frame that there is room for.
pub const MAX_DRAWS: usize = 96;
const STRIDE: u64 = 256;

struct Texture {
    texture: wgpu::Texture,
    view: wgpu::TextureView,
    version: u64,
    scale: f32,
}

/// Pipeline and textures; one per device.
pub struct FilmGpu {
    shader: wgpu::ShaderModule,
    format: wgpu::TextureFormat,
    pipelines: Vec<(Variant, wgpu::RenderPipeline)>,
    layout: wgpu::BindGroupLayout,
    looks: wgpu::Buffer,
    maps: wgpu::TextureView,
    smooth: wgpu::Sampler,
    textures: [Texture; N_SLOTS],
    bind_groups: [[Option<wgpu::BindGroup>; N_SLOTS]; N_SLOTS],
    largest: u32,
    pub(super) ground: GroundGpu,
}

impl FilmGpu {
    /// Prepares for drawing to a target of the given format.
    #[must_use]
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue, format: wgpu::TextureFormat) -> Self {
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("film"),
            entries: &[
                entry(
                    0,
                    wgpu::BindingType::Buffer {
                        ty: wgpu::BufferBindingType::Uniform,
                        has_dynamic_offset: true,
                        min_binding_size: wgpu::BufferSize::new(size_of::<Look>() as u64),
                    },
                ),
                entry(1, TEXTURE),
                entry(2, TEXTURE),
                entry(3, TEXTURE),
                entry(4, SAMPLER),
            ],
        });
        Self {
            shader: device.create_shader_module(wgpu::include_wgsl!("display.wgsl")),
            format,
            pipelines: Vec::new(),
            layout,
            looks: device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("looks"),
                size: STRIDE * MAX_DRAWS as u64,
                usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            }),
            maps: maps(device, queue),
            smooth: device.create_sampler(&wgpu::SamplerDescriptor {
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                ..wgpu::SamplerDescriptor::default()
            }),
            textures: std::array::from_fn(|_| texture(device, 1, 1)),
            bind_groups: Default::default(),
            largest: device.limits().max_texture_dimension_2d,
            ground: GroundGpu::new(device, format),
        }
    }

    fn upload(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, planes: &Planes, slot: Slot) {
        let plane = planes.plane(slot);
        let index = slot as usize;
        let (width, height) = (plane.width as u32, plane.height as u32);
        let fits = width > 0 && height > 0 && width.max(height) <= self.largest;
        if !fits || self.textures[index].version == plane.version {
            return;
        }
        let size = self.textures[index].texture.size();
        if (size.width, size.height) != (width, height) {
            self.textures[index] = texture(device, width, height);
            for row in &mut self.bind_groups {
                row[index] = None;
            }
            self.bind_groups[index] = Default::default();
        }
        let target = &mut self.textures[index];
        target.version = plane.version;
        target.scale = plane.scale;
        queue.write_texture(
            target.texture.as_image_copy(),
            bytemuck::cast_slice(as_bits(&plane.pixels)),
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(8 * width),
                rows_per_image: None,
            },
            wgpu::Extent3d {
                width,
                height,
                depth_or_array_layers: 1,
            },
        );
    }

    /// Makes the pipeline of a variant when it is first asked for.
    fn prepare(&mut self, device: &wgpu::Device, variant: Variant) {
        if self.pipelines.iter().any(|(made, _)| *made == variant) {
            return;
        }
        let flag = |is_on: bool| f64::from(u8::from(is_on));
        let constants = [
            ("TONE", variant.tone as f64),
            ("MODE", f64::from(variant.mode as u8)),
            ("IS_WIPING", flag(variant.is_wiping)),
            ("IS_SMOOTH", flag(variant.is_smooth)),
            ("TARGET_ENCODES", flag(self.format.is_srgb())),
        ];
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("film"),
            bind_group_layouts: &[Some(&self.layout)],
            immediate_size: 0,
        });
        let options = wgpu::PipelineCompilationOptions {
            constants: &constants,
            ..Default::default()
        };
        let pipeline = covering_pipeline(device, &self.shader, &layout, self.format, options);
        self.pipelines.push((variant, pipeline));
    }

    fn bind(&mut self, device: &wgpu::Device, left: usize, right: usize) {
        if self.bind_groups[left][right].is_some() {
            return;
        }
        let resource = wgpu::BindingResource::TextureView;
        let entries = [
            wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                buffer: &self.looks,
                offset: 0,
                size: wgpu::BufferSize::new(size_of::<Look>() as u64),
            }),
            resource(&self.textures[left].view),
            resource(&self.textures[right].view),
            resource(&self.maps),
            wgpu::BindingResource::Sampler(&self.smooth),
        ];
        let entries: Vec<_> = entries
            .into_iter()
            .zip(0..)
            .map(|(resource, binding)| wgpu::BindGroupEntry { binding, resource })
            .collect();
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("film"),
            layout: &self.layout,
            entries: &entries,
        });
        self.bind_groups[left][right] = Some(group);
    }
}

impl CallbackTrait for Draw {
    fn prepare(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        _: &ScreenDescriptor,
        _: &mut wgpu::CommandEncoder,
        resources: &mut CallbackResources,
    ) -> Vec<wgpu::CommandBuffer> {
        let Some(gpu) = resources.get_mut::<FilmGpu>() else {
            return Vec::new();
        };
        {
            let planes = self.planes.lock();
            gpu.upload(device, queue, &planes, self.left);
            gpu.upload(device, queue, &planes, self.right);
        }
        let (left, right) = (self.left as usize, self.right as usize);
        gpu.bind(device, left, right);
        gpu.prepare(device, self.variant);
        let mut look = self.look;
        look.scale[0] = gpu.textures[left].scale;
        look.scale[1] = gpu.textures[right].scale;
        let offset = STRIDE * self.index.min(MAX_DRAWS - 1) as u64;
        queue.write_buffer(&gpu.looks, offset, bytemuck::bytes_of(&look));
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
        let Some(group) = &gpu.bind_groups[self.left as usize][self.right as usize] else {
            return;
        };
        let offset = STRIDE as u32 * self.index.min(MAX_DRAWS - 1) as u32;
        let mut pipelines = gpu.pipelines.iter();
        let Some((_, pipeline)) = pipelines.find(|(variant, _)| *variant == self.variant) else {
            return;
        };
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, group, &[offset]);
        pass.draw(0..3, 0..1);
    }
}

/// A pipeline that covers its viewport: a shader's `cover`, then its `shade`.
pub(super) fn covering_pipeline(
    device: &wgpu::Device,
    shader: &wgpu::ShaderModule,
    layout: &wgpu::PipelineLayout,
    format: wgpu::TextureFormat,
    options: wgpu::PipelineCompilationOptions<'_>,
) -> wgpu::RenderPipeline {
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("covering"),
        layout: Some(layout),
        vertex: wgpu::VertexState {
            module: shader,
            entry_point: Some("cover"),
            compilation_options: options.clone(),
            buffers: &[],
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: None,
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module: shader,
            entry_point: Some("shade"),
            compilation_options: options,
            targets: &[Some(format.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}

const TEXTURE: wgpu::BindingType = wgpu::BindingType::Texture {
    sample_type: wgpu::TextureSampleType::Float { filterable: true },
    view_dimension: wgpu::TextureViewDimension::D2,
    multisampled: false,
};
const SAMPLER: wgpu::BindingType = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering);

fn entry(binding: u32, ty: wgpu::BindingType) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::FRAGMENT,
        ty,
        count: None,
    }
}

fn texture(device: &wgpu::Device, width: u32, height: u32) -> Texture {
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: Some("picture"),
        size: wgpu::Extent3d {
            width,
            height,
            depth_or_array_layers: 1,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba16Float,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
    Texture {
        texture,
        view,
        version: 0,
        scale: 1.0,
    }
}

/// All colour maps, a row each, and the signed one below them.
fn maps(device: &wgpu::Device, queue: &wgpu::Queue) -> wgpu::TextureView {
    let mut codes: Vec<u8> = Vec::new();
    for map in ColourMap::ALL {
        for i in 0..256 {
            codes.extend(map.rgb(i as f32 / 255.0));
            codes.push(255);
        }
    }
    for i in 0..256 {
        codes.extend(diverging(i as f32 / 127.5 - 1.0));
        codes.push(255);
    }
    let size = wgpu::Extent3d {
        width: 256,
        height: ColourMap::ALL.len() as u32 + 1,
        depth_or_array_layers: 1,
    };
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: Some("colour maps"),
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8Unorm,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    queue.write_texture(
        texture.as_image_copy(),
        &codes,
        wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(4 * 256),
            rows_per_image: None,
        },
        size,
    );
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

fn as_bits(pixels: &[half::f16]) -> &[u16] {
    use half::slice::HalfFloatSliceExt;
    pixels.reinterpret_cast()
}
