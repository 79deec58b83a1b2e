//! The relief view on the graphics device: a picture with its own depth, drawn beside the window's and copied in.

use std::sync::Arc;

use eframe::wgpu::{self, util::DeviceExt as _};
use eframe::{egui, egui_wgpu};

use super::pieces::{Piece, Sight, grid, pieces};
use crate::value::Field;

const COLOR: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;
const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
/// Samples of a pixel, so that edges are smooth.
const SAMPLES: u32 = 4;

/// A terrain to draw: heights, and the picture that is draped over them.
#[derive(Clone, Debug)]
pub(crate) struct Terrain {
    /// Another for each terrain: tells what the device has already.
    pub(crate) id: u64,
    pub(crate) height: Field,
    /// Another for each picture.
    pub(crate) picture_id: u64,
    pub(crate) picture: Arc<crate::render::Picture>,
}

/// One picture to draw.
#[derive(Clone, Debug)]
pub(crate) struct Frame {
    pub(crate) terrain: Terrain,
    pub(crate) sight: Sight,
    pub(crate) exaggeration: f32,
    /// Height of the water, in metres.
    pub(crate) water: Option<f32>,
    pub(crate) background: [f32; 3],
    /// Size of the picture, in pixels.
    pub(crate) pixels: [u32; 2],
    /// The format of the window.
    pub(crate) format: wgpu::TextureFormat,
}

/// What the shader reads; see `Scene` in terrain.wgsl.
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct Uniform {
    to_screen: [[f32; 4]; 4],
    place: [f32; 4],
    size: [f32; 4],
    heights: [f32; 4],
    water: [f32; 4],
}

impl Frame {
    fn uniform(&self) -> Uniform {
        let (s, [low, high]) = (&self.sight, self.range());
        let middle = 0.5 * (low + high);
        let water = self.water.map_or(f32::MIN, |w| (w - middle) * self.exaggeration);
        let (cols, rows) = (s.cols as f32, s.rows as f32);
        let foot = (low - middle) * self.exaggeration - 0.04 * s.cell * cols.max(rows);
        Uniform {
            to_screen: s.to_screen.to_cols_array_2d(),
            place: [s.corner[0], s.corner[1], s.cell, self.exaggeration],
            size: [cols, rows, water, f32::from(u8::from(self.water.is_some()))],
            heights: [middle, foot, (high - low) * self.exaggeration, 0.0],
            water: [0.16, 0.33, 0.47, 0.0],
        }
    }

    fn range(&self) -> [f32; 2] {
        self.terrain.height.range().map_or([0.0; 2], |(a, b)| [a, b])
    }
}

impl egui_wgpu::CallbackTrait for Frame {
    fn prepare(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        _screen: &egui_wgpu::ScreenDescriptor,
        encoder: &mut wgpu::CommandEncoder,
        resources: &mut egui_wgpu::CallbackResources,
    ) -> Vec<wgpu::CommandBuffer> {
        if !resources.contains::<Stage>() {
            resources.insert(Stage::new(device, self.format));
        }
        if let Some(stage) = resources.get_mut::<Stage>() {
            stage.draw(device, queue, encoder, self);
        }
        Vec::new()
    }

    fn paint(
        &self,
        _info: egui::PaintCallbackInfo,
        pass: &mut wgpu::RenderPass<'static>,
        resources: &egui_wgpu::CallbackResources,
    ) {
        let Some(stage) = resources.get::<Stage>() else { return };
        let Some(target) = &stage.target else { return };
        pass.set_pipeline(&stage.copy);
        pass.set_bind_group(0, &target.group, &[]);
        pass.draw(0..3, 0..1);
    }
}

/// What stays on the device between frames.
struct Stage {
    ground: wgpu::RenderPipeline,
    wall: wgpu::RenderPipeline,
    sea: wgpu::RenderPipeline,
    copy: wgpu::RenderPipeline,
    scene_layout: wgpu::BindGroupLayout,
    copy_layout: wgpu::BindGroupLayout,
    uniform: wgpu::Buffer,
    corners: wgpu::Buffer,
    triangles: wgpu::Buffer,
    count: u32,
    draped: wgpu::Sampler,
    smooth: wgpu::Sampler,
    loaded: Option<Loaded>,
    target: Option<Target>,
}

/// A terrain on the device.
struct Loaded {
    id: u64,
    picture_id: u64,
    field: wgpu::TextureView,
    group: wgpu::BindGroup,
    walls: wgpu::Buffer,
    wall_count: u32,
}

/// What is drawn into.
struct Target {
    size: [u32; 2],
    color: wgpu::TextureView,
    depth: wgpu::TextureView,
    resolved: wgpu::TextureView,
    group: wgpu::BindGroup,
}

impl Stage {
    fn new(device: &wgpu::Device, format: wgpu::TextureFormat) -> Self {
        let terrain = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("terrain"),
            source: wgpu::ShaderSource::Wgsl(include_str!("../../../../shaders/view/terrain.wgsl").into()),
        });
        let copy = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("copy"),
            source: wgpu::ShaderSource::Wgsl(include_str!("../../../../shaders/view/copy.wgsl").into()),
        });
        let scene_layout = layout(
            device,
            &[uniform_entry(), texture_entry(1, false), texture_entry(2, true), sampler_entry(3)],
        );
        let copy_layout = layout(device, &[texture_entry(0, true), sampler_entry(1)]);
        let (corners, triangles) = grid();
        let buffer = |contents: &[u8], usage| {
            device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: None, contents, usage })
        };
        let parts = wgpu::vertex_attr_array![0 => Float32x3];
        let places = wgpu::vertex_attr_array![1 => Float32x3];
        let part = wgpu::VertexBufferLayout {
            array_stride: 12,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes: &parts,
        };
        let place = wgpu::VertexBufferLayout {
            array_stride: size_of::<Piece>() as u64,
            step_mode: wgpu::VertexStepMode::Instance,
            attributes: &places,
        };
        let make = |entry: [&str; 2], buffers: &[Option<wgpu::VertexBufferLayout<'_>>], strip, blend| {
            let spec = Spec { module: &terrain, entry, buffers, strip, blend, format: COLOR, depth: true };
            pipeline(device, &scene_layout, &spec)
        };
        let copy_spec = Spec {
            module: &copy,
            entry: ["corner", "shown"],
            buffers: &[],
            strip: false,
            blend: None,
            format,
            depth: false,
        };
        let sampler = |anisotropy: u16| {
            device.create_sampler(&wgpu::SamplerDescriptor {
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                mipmap_filter: wgpu::MipmapFilterMode::Linear,
                anisotropy_clamp: anisotropy,
                ..wgpu::SamplerDescriptor::default()
            })
        };
        Self {
            ground: make(["ground", "draped"], &[Some(part.clone()), Some(place)], false, None),
            wall: make(["wall", "draped"], &[Some(part)], true, None),
            sea: make(["sea", "wet"], &[], true, Some(wgpu::BlendState::ALPHA_BLENDING)),
            copy: pipeline(device, &copy_layout, &copy_spec),
            uniform: device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("scene"),
                size: size_of::<Uniform>() as u64,
                usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            }),
            corners: buffer(bytemuck::cast_slice(&corners), wgpu::BufferUsages::VERTEX),
            count: triangles.len() as u32,
            triangles: buffer(bytemuck::cast_slice(&triangles), wgpu::BufferUsages::INDEX),
            draped: sampler(8),
            smooth: sampler(1),
            scene_layout,
            copy_layout,
            loaded: None,
            target: None,
        }
    }

    fn draw(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        encoder: &mut wgpu::CommandEncoder,
        frame: &Frame,
    ) {
        self.load(device, queue, &frame.terrain);
        self.aim(device, frame.pixels);
        queue.write_buffer(&self.uniform, 0, bytemuck::bytes_of(&frame.uniform()));
        let pieces = pieces(&frame.sight);
        let places = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("pieces"),
            contents: bytemuck::cast_slice(&pieces),
            usage: wgpu::BufferUsages::VERTEX,
        });
        let (Some(loaded), Some(target)) = (&self.loaded, &self.target) else { return };
        let [r, g, b] = frame.background.map(f64::from);
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("relief"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &target.color,
                resolve_target: Some(&target.resolved),
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color { r, g, b, a: 1.0 }),
                    store: wgpu::StoreOp::Discard,
                },
                depth_slice: None,
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &target.depth,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(1.0),
                    store: wgpu::StoreOp::Discard,
                }),
                stencil_ops: None,
            }),
            ..wgpu::RenderPassDescriptor::default()
        });
        pass.set_bind_group(0, &loaded.group, &[]);
        if !pieces.is_empty() {
            pass.set_pipeline(&self.ground);
            pass.set_vertex_buffer(0, self.corners.slice(..));
            pass.set_vertex_buffer(1, places.slice(..));
            pass.set_index_buffer(self.triangles.slice(..), wgpu::IndexFormat::Uint16);
            pass.draw_indexed(0..self.count, 0, 0..pieces.len() as u32);
        }
        pass.set_pipeline(&self.wall);
        pass.set_vertex_buffer(0, loaded.walls.slice(..));
        pass.draw(0..loaded.wall_count, 0..1);
        if frame.water.is_some() {
            pass.set_pipeline(&self.sea);
            pass.draw(0..4, 0..1);
        }
    }

    /// Brings a terrain to the device, as far as it is not there.
    fn load(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, terrain: &Terrain) {
        let held = self.loaded.as_ref().filter(|l| l.id == terrain.id);
        if held.is_some_and(|l| l.picture_id == terrain.picture_id) {
            return;
        }
        let field = held.map(|l| (l.field.clone(), l.walls.clone(), l.wall_count));
        let (field, walls, wall_count) = field.unwrap_or_else(|| {
            let corners = walls(terrain.height.grid().cols as u32, terrain.height.grid().rows as u32);
            let walls = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some("walls"),
                contents: bytemuck::cast_slice(&corners),
                usage: wgpu::BufferUsages::VERTEX,
            });
            (field_texture(device, queue, &terrain.height), walls, corners.len() as u32)
        });
        let picture = picture_texture(device, queue, &terrain.picture);
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("scene"),
            layout: &self.scene_layout,
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: self.uniform.as_entire_binding() },
                wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::TextureView(&field) },
                wgpu::BindGroupEntry { binding: 2, resource: wgpu::BindingResource::TextureView(&picture) },
                wgpu::BindGroupEntry { binding: 3, resource: wgpu::BindingResource::Sampler(&self.draped) },
            ],
        });
        let (id, picture_id) = (terrain.id, terrain.picture_id);
        self.loaded = Some(Loaded { id, picture_id, field, group, walls, wall_count });
    }

    /// Makes the picture that is drawn into, when the view has another size.
    fn aim(&mut self, device: &wgpu::Device, size: [u32; 2]) {
        if self.target.as_ref().is_some_and(|t| t.size == size) {
            return;
        }
        let texture = |format, samples, usage| {
            let texture = device.create_texture(&wgpu::TextureDescriptor {
                label: Some("relief"),
                size: wgpu::Extent3d { width: size[0], height: size[1], depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: samples,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT | usage,
                view_formats: &[],
            });
            texture.create_view(&wgpu::TextureViewDescriptor::default())
        };
        let none = wgpu::TextureUsages::empty();
        let resolved = texture(COLOR, 1, wgpu::TextureUsages::TEXTURE_BINDING);
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("copy"),
            layout: &self.copy_layout,
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: wgpu::BindingResource::TextureView(&resolved) },
                wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::Sampler(&self.smooth) },
            ],
        });
        let (color, depth) = (texture(COLOR, SAMPLES, none), texture(DEPTH, SAMPLES, none));
        self.target = Some(Target { size, color, depth, resolved, group });
    }
}

/// The four cut sides of the block as one strip: sample and whether the corner is at the foot.
fn walls(cols: u32, rows: u32) -> Vec<[f32; 3]> {
    let (c, r) = (cols - 1, rows - 1);
    let north = (0..=c).map(|i| [i, 0]);
    let east = (0..=r).map(|j| [c, j]);
    let south = (0..=c).rev().map(|i| [i, r]);
    let west = (0..=r).rev().map(|j| [0, j]);
    let around = north.chain(east).chain(south).chain(west);
    around.flat_map(|[i, j]| [[i as f32, j as f32, 0.0], [i as f32, j as f32, 1.0]]).collect()
}

fn field_texture(device: &wgpu::Device, queue: &wgpu::Queue, field: &Field) -> wgpu::TextureView {
    let size = wgpu::Extent3d {
        width: field.grid().cols as u32,
        height: field.grid().rows as u32,
        depth_or_array_layers: 1,
    };
    let descriptor = wgpu::TextureDescriptor {
        label: Some("heights"),
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::R32Float,
        usage: wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    };
    let order = wgpu::util::TextureDataOrder::LayerMajor;
    let data = bytemuck::cast_slice(field.data());
    let texture = device.create_texture_with_data(queue, &descriptor, order, data);
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

/// The picture with all its smaller versions, so that far ground does not flicker.
fn picture_texture(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    picture: &crate::render::Picture,
) -> wgpu::TextureView {
    let mut size = [picture.width.max(1), picture.height.max(1)];
    let mut level: Vec<[u8; 4]> = picture.rgb.iter().map(|c| [c[0], c[1], c[2], 255]).collect();
    let (mut data, mut levels) = (Vec::new(), 0);
    let first = size;
    loop {
        data.extend_from_slice(bytemuck::cast_slice(&level));
        levels += 1;
        if size == [1, 1] {
            break;
        }
        (level, size) = halved(&level, size);
    }
    let descriptor = wgpu::TextureDescriptor {
        label: Some("picture"),
        size: wgpu::Extent3d { width: first[0] as u32, height: first[1] as u32, depth_or_array_layers: 1 },
        mip_level_count: levels,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: COLOR,
        usage: wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    };
    let order = wgpu::util::TextureDataOrder::LayerMajor;
    let texture = device.create_texture_with_data(queue, &descriptor, order, &data);
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

fn halved(from: &[[u8; 4]], [w, h]: [usize; 2]) -> (Vec<[u8; 4]>, [usize; 2]) {
    let size = [(w / 2).max(1), (h / 2).max(1)];
    let mut out = Vec::with_capacity(size[0] * size[1]);
    for j in 0..size[1] {
        for i in 0..size[0] {
            let at = |di: usize, dj: usize| from[(2 * j + dj).min(h - 1) * w + (2 * i + di).min(w - 1)];
            let four = [at(0, 0), at(1, 0), at(0, 1), at(1, 1)];
            out.push(std::array::from_fn(|k| {
                let sum: u32 = four.iter().map(|c| u32::from(c[k])).sum();
                ((sum + 2) / 4) as u8
            }));
        }
    }
    (out, size)
}

fn layout(device: &wgpu::Device, entries: &[wgpu::BindGroupLayoutEntry]) -> wgpu::BindGroupLayout {
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: None, entries })
}

fn uniform_entry() -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding: 0,
        visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
        ty: wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset: false,
            min_binding_size: None,
        },
        count: None,
    }
}

fn texture_entry(binding: u32, filterable: bool) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
        ty: wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable },
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        },
        count: None,
    }
}

fn sampler_entry(binding: u32) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::FRAGMENT,
        ty: wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering),
        count: None,
    }
}

/// What differs between the pipelines.
struct Spec<'a> {
    module: &'a wgpu::ShaderModule,
    /// Of the vertices and of the fragments.
    entry: [&'a str; 2],
    buffers: &'a [Option<wgpu::VertexBufferLayout<'a>>],
    strip: bool,
    blend: Option<wgpu::BlendState>,
    format: wgpu::TextureFormat,
    depth: bool,
}

fn pipeline(device: &wgpu::Device, group: &wgpu::BindGroupLayout, spec: &Spec<'_>) -> wgpu::RenderPipeline {
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: None,
        bind_group_layouts: &[Some(group)],
        immediate_size: 0,
    });
    let topology = if spec.strip {
        wgpu::PrimitiveTopology::TriangleStrip
    } else {
        wgpu::PrimitiveTopology::TriangleList
    };
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(spec.entry[0]),
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module: spec.module,
            entry_point: Some(spec.entry[0]),
            buffers: spec.buffers,
            compilation_options: wgpu::PipelineCompilationOptions::default(),
        },
        primitive: wgpu::PrimitiveState { topology, ..wgpu::PrimitiveState::default() },
        depth_stencil: spec.depth.then(|| wgpu::DepthStencilState {
            format: DEPTH,
            depth_write_enabled: Some(spec.blend.is_none()),
            depth_compare: Some(wgpu::CompareFunction::LessEqual),
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState::default(),
        }),
        multisample: wgpu::MultisampleState {
            count: if spec.depth { SAMPLES } else { 1 },
            ..wgpu::MultisampleState::default()
        },
        fragment: Some(wgpu::FragmentState {
            module: spec.module,
            entry_point: Some(spec.entry[1]),
            targets: &[Some(wgpu::ColorTargetState {
                format: spec.format,
                blend: spec.blend,
                write_mask: wgpu::ColorWrites::ALL,
            })],
            compilation_options: wgpu::PipelineCompilationOptions::default(),
        }),
        multiview_mask: None,
        cache: None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn walls_go_once_around() {
        let corners = walls(3, 2);
        assert_eq!(corners.len(), 2 * (3 + 2 + 3 + 2));
        assert_eq!(corners.first(), Some(&[0.0, 0.0, 0.0]));
        assert_eq!(corners.last(), Some(&[0.0, 0.0, 1.0]));
    }

    #[test]
    fn smaller_pictures_keep_the_mean() {
        let (one, size) = halved(&[[0, 8, 0, 255], [4, 8, 0, 255]], [2, 1]);
        assert_eq!((one, size), (vec![[2, 8, 0, 255]], [1, 1]));
    }
}
