//! The relief view on the graphics device. It is drawn into a picture with a depth buffer of its own, which is then
//! copied into the window.

use std::sync::Arc;

use eframe::wgpu::{self, util::DeviceExt as _};
use eframe::{egui, egui_wgpu};

use super::pieces::{Piece, Sight, grid, pieces};
use super::pipeline::{
    COLOR, DEPTH, SAMPLES, Spec, layout, pipeline, sampler_entry, texture_entry, uniform_entry,
};
use super::texture::{field_texture, picture_texture, walls};
use crate::value::Field;

/// A terrain to draw: heights, and the picture that is draped over them.
#[derive(Clone, Debug)]
pub(crate) struct DrawnTerrain {
    /// A number that differs for each terrain, to tell whether the device has it already.
    pub(crate) id: u64,
    pub(crate) height: Field,
    /// A number that differs for each picture.
    pub(crate) picture_id: u64,
    pub(crate) picture: Arc<crate::render::Picture>,
}

/// One picture to draw.
#[derive(Clone, Debug)]
pub(crate) struct Frame {
    pub(crate) terrain: DrawnTerrain,
    pub(crate) sight: Sight,
    pub(crate) exaggeration: f32,
    /// Lowest and highest point in metres, the same for two terrains in comparison.
    pub(crate) range: [f32; 2],
    /// The index of the terrain: 0, or 1 for the one in comparison.
    pub(crate) slot: usize,
    /// Height of the water, in metres.
    pub(crate) water: Option<f32>,
    pub(crate) background: [f32; 3],
    /// Size of the picture, in pixels.
    pub(crate) pixels: [u32; 2],
    /// The format of the window.
    pub(crate) format: wgpu::TextureFormat,
}

/// The uniforms of the shader, see `Scene` in terrain.wgsl.
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
        let (s, [low, high]) = (&self.sight, self.range);
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
        let states = resources.entry::<DeviceStates>().or_insert_with(DeviceStates::default);
        if let Some(state) = states.0.get_mut(self.slot) {
            state
                .get_or_insert_with(|| DeviceState::new(device, self.format))
                .draw(device, queue, encoder, self);
        }
        Vec::new()
    }

    fn paint(
        &self,
        _info: egui::PaintCallbackInfo,
        pass: &mut wgpu::RenderPass<'static>,
        resources: &egui_wgpu::CallbackResources,
    ) {
        let states = resources.get::<DeviceStates>();
        let Some(state) = states.and_then(|s| s.0.get(self.slot)?.as_ref()) else { return };
        let Some(target) = &state.target else { return };
        pass.set_pipeline(&state.copy);
        pass.set_bind_group(0, &target.group, &[]);
        pass.draw(0..3, 0..1);
    }
}

/// The state of each of two terrains in comparison.
#[derive(Default)]
struct DeviceStates([Option<DeviceState>; 2]);

/// Pipelines, buffers and textures that stay on the device between frames.
struct DeviceState {
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

/// The textures into which a frame is drawn.
struct Target {
    size: [u32; 2],
    color: wgpu::TextureView,
    depth: wgpu::TextureView,
    resolved: wgpu::TextureView,
    group: wgpu::BindGroup,
}

impl DeviceState {
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

    /// Uploads a terrain and its picture, unless they are on the device already.
    fn load(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, terrain: &DrawnTerrain) {
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

    /// Makes new textures to draw into, when the view has another size.
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
