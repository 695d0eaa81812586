//! Binary glTF 2.0 of a clip: a skeleton of nodes, a skinned mesh of its solids, an animation.
//!
//! In: a [`Clip`] and solids fixed to its links. Out: the bytes of a `.glb`. glTF has our frame and units
//! (metres, Y up, +Z forward), so nothing is turned or scaled; doubles become floats.
//!
//! Node i is link i, at rest in the zero pose: `parent_from_zero`. A rigid body would only need meshes hung
//! on nodes, but importers make an armature of a *skin*; so there is one mesh, every vertex of weight 1 to
//! its link, in the coordinates of the zero pose, and the inverse bind matrices are `world_from_link⁻¹` of
//! that pose.
//!
//! The animation has a key per frame, linear (for rotations: slerp): `parent_from_link` of the frame, the
//! rotation unless the joint cannot turn, the translation only where the joint moves. Quaternions of
//! neighbouring keys lie in one hemisphere, which interpolation needs.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::Path;

use gltf_json as json;
use json::accessor::{ComponentType, GenericComponentType, Type};
use json::animation::{Interpolation, Property};
use json::buffer::Target;
use json::validation::Checked::Valid;
use json::validation::USize64;
use json::{Index, Root};
use thiserror::Error;

use super::FileError;
use motion::{Clip, Joint, Kinematics, Shape, Skeleton, Vec3};

mod mesh;

/// Why a clip cannot be written as glTF.
#[derive(Debug, Error)]
pub enum GlbError {
    /// The file could not be written.
    #[error(transparent)]
    File(#[from] FileError),
    /// A solid on a link that does not exist.
    #[error("solid {solid} is on link {link}; the skeleton has {links} links")]
    Link {
        /// The solid, from 0.
        solid: usize,
        /// Its link.
        link: usize,
        /// Number of links.
        links: usize,
    },
    /// A solid without volume, or with a number that is not finite.
    #[error("solid {solid} on `{link}` has a radius or edge that is not a positive number")]
    Solid {
        /// The solid, from 0.
        solid: usize,
        /// Its link.
        link: String,
    },
    /// A value that is NaN, infinite or too large for a float.
    #[error("frame {frame} of `{link}` is not a finite float")]
    NotFinite {
        /// Frame, from 0.
        frame: usize,
        /// The link.
        link: String,
    },
    /// Key times that floats cannot tell apart.
    #[error("{frames} frames at {rate_hz} Hz are too many for the float times of glTF")]
    TooLong {
        /// Number of frames.
        frames: usize,
        /// Frame rate, Hz.
        rate_hz: f64,
    },
    /// More than the 4 GB a GLB holds, or more links than a skin.
    #[error(
        "the clip is too large for a GLB file: {bytes} bytes, {links} links; at most 4294967295 and 65536"
    )]
    TooLarge {
        /// Size of the data.
        bytes: usize,
        /// Number of links.
        links: usize,
    },
    /// The encoder failed.
    #[error("cannot encode {what}: {message}")]
    Encode {
        /// What was being encoded.
        what: &'static str,
        /// Why it failed.
        message: String,
    },
}

/// Capsules along the bones, for a clip of which nothing but the skeleton is known.
///
/// From each link to its children and to its end, a tenth of the bone thick and at most 5 cm.
pub fn bones(skeleton: &Skeleton) -> Vec<(usize, Shape)> {
    let mut out = Vec::new();
    let mut bone = |link: usize, b: Vec3| {
        let length = b.norm();
        if length > 1e-3 {
            out.push((link, Shape::Capsule { a: Vec3::zeros(), b, radius: (0.1 * length).min(0.05) }));
        }
    };
    for (i, link) in skeleton.links().iter().enumerate() {
        if let Some(parent) = link.parent {
            bone(parent, link.parent_from_zero.translation.vector);
        }
        if let Some(end) = link.end {
            bone(i, end);
        }
    }
    out
}

/// Writes a clip; whole or not at all.
///
/// # Errors
/// See [`GlbError`].
pub fn write_file(
    path: &Path,
    clip: &Clip,
    solids: &[(usize, Shape)],
    colors: &[Option<[u8; 3]>],
    name: &str,
) -> Result<(), GlbError> {
    Ok(super::write(path, &write(clip, solids, colors, name)?)?)
}

/// Bytes of a `.glb` with the clip's skeleton, `solids` (link, shape in its frame) and motion.
///
/// `name` names the scene, the mesh and the animation. Without solids there is neither mesh nor skin;
/// [`bones`] makes some.
///
/// * `colors`: red, green, blue per link as screens show them (sRGB); clay where there is none, or no entry
///
/// # Errors
/// See [`GlbError`].
pub fn write(
    clip: &Clip,
    solids: &[(usize, Shape)],
    colors: &[Option<[u8; 3]>],
    name: &str,
) -> Result<Vec<u8>, GlbError> {
    let links = clip.skeleton.links();
    if links.len() > 1 << 16 {
        return Err(GlbError::TooLarge { bytes: 0, links: links.len() });
    }
    check_solids(&clip.skeleton, solids)?;
    let mut file = File { root: Root::default(), bytes: Vec::new() };
    file.root.asset = json::Asset {
        generator: Some(concat!("Contrapposto ", env!("CARGO_PKG_VERSION")).into()),
        version: "2.0".into(),
        ..Default::default()
    };
    let mut scene = vec![file.nodes(&clip.skeleton)];
    if !solids.is_empty() {
        scene.push(file.body(&clip.skeleton, solids, colors, name));
    }
    file.animation(clip, name)?;
    let scene = file.root.push(json::Scene {
        extensions: None,
        extras: Default::default(),
        name: Some(name.into()),
        nodes: scene,
    });
    file.root.scene = Some(scene);
    file.finish(links.len())
}

fn check_solids(skeleton: &Skeleton, solids: &[(usize, Shape)]) -> Result<(), GlbError> {
    let links = skeleton.links();
    for (solid, &(link, shape)) in solids.iter().enumerate() {
        if link >= links.len() {
            return Err(GlbError::Link { solid, link, links: links.len() });
        }
        let (least, places) = match shape {
            Shape::Capsule { a, b, radius } => (radius, a + b),
            Shape::Sphere { center, radius } => (radius, center),
            Shape::Box { center, half, rotation } => (half.min(), center + half + rotation.imag()),
            Shape::Cone { a, b, radius_a, radius_b } => (radius_a.min(radius_b).min((b - a).norm()), a + b),
        };
        let sound = least > 0.0 && least.is_finite() && places.iter().all(|x| x.abs() < f64::from(f32::MAX));
        if !sound {
            return Err(GlbError::Solid { solid, link: links[link].name.clone() });
        }
    }
    Ok(())
}

/// The document and the data it points into.
struct File {
    root: Root,
    bytes: Vec<u8>,
}

impl File {
    /// A node for each link, in order; returns the root's.
    fn nodes(&mut self, skeleton: &Skeleton) -> Index<json::Node> {
        let links = skeleton.links();
        let mut children = vec![Vec::new(); links.len()];
        for (i, link) in links.iter().enumerate() {
            if let Some(parent) = link.parent {
                children[parent].push(Index::new(i as u32));
            }
        }
        for (link, children) in links.iter().zip(children) {
            let zero = &link.parent_from_zero;
            self.root.push(json::Node {
                name: Some(link.name.clone()),
                children: (!children.is_empty()).then_some(children),
                translation: Some(vec3(&zero.translation.vector)),
                rotation: Some(json::scene::UnitQuaternion(zero.rotation.coords.map(|x| x as f32).into())),
                ..Default::default()
            });
        }
        Index::new(0)
    }

    /// A matt material.
    fn material(&mut self, color: Option<[u8; 3]>) -> Index<json::Material> {
        // factors are linear, colours as written are sRGB (IEC 61966-2-1)
        let linear = |x: u8| {
            let x = f32::from(x) / 255.0;
            if x <= 0.04045 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
        };
        let (name, [r, g, b]) = match color {
            Some([r, g, b]) => (format!("#{r:02x}{g:02x}{b:02x}"), [r, g, b].map(linear)),
            None => ("clay".to_owned(), [0.7, 0.68, 0.65]),
        };
        self.root.push(json::Material {
            name: Some(name),
            pbr_metallic_roughness: json::material::PbrMetallicRoughness {
                base_color_factor: json::material::PbrBaseColorFactor([r, g, b, 1.0]),
                metallic_factor: json::material::StrengthFactor(0.0),
                roughness_factor: json::material::StrengthFactor(0.8),
                ..Default::default()
            },
            ..Default::default()
        })
    }

    /// The mesh of all solids, its skin, and the node that shows it.
    fn body(
        &mut self,
        skeleton: &Skeleton,
        solids: &[(usize, Shape)],
        colors: &[Option<[u8; 3]>],
        name: &str,
    ) -> Index<json::Node> {
        let zero = Kinematics::new(skeleton, &skeleton.zero_pose());
        let (mut points, mut normals) = (Vec::new(), Vec::new());
        let (mut joints, mut weights) = (Vec::new(), Vec::new());
        // corners by colour: one primitive each
        let mut painted: BTreeMap<Option<[u8; 3]>, Vec<u32>> = BTreeMap::new();
        for (link, shape) in solids {
            let mesh = mesh::mesh(shape);
            let first = points.len() as u32;
            let indices = painted.entry(colors.get(*link).copied().flatten()).or_default();
            indices.extend(mesh.indices.iter().map(|i| first + i));
            for (point, normal) in mesh.points.iter().zip(&mesh.normals) {
                points.push(vec3(&zero.point(*link, point)));
                normals.push(vec3(&(zero.world[*link].rotation * normal)));
                joints.push([*link as u16, 0, 0, 0]);
                weights.push([1.0f32, 0.0, 0.0, 0.0]);
            }
        }
        let vertices = points.len();
        let (min, max) = bounds(&points);
        let attribute = Some(Target::ArrayBuffer);
        let points = self.floats(points.as_flattened(), Type::Vec3, vertices, attribute);
        self.root.accessors[points.value()].min = Some(min);
        self.root.accessors[points.value()].max = Some(max);
        let normals = self.floats(normals.as_flattened(), Type::Vec3, vertices, attribute);
        let joints: Vec<u8> = joints.as_flattened().iter().flat_map(|j| j.to_le_bytes()).collect();
        let joints = self.accessor(&joints, ComponentType::U16, Type::Vec4, vertices, attribute);
        let weights = self.floats(weights.as_flattened(), Type::Vec4, vertices, attribute);
        use json::mesh::Semantic;
        let attributes = BTreeMap::from([
            (Valid(Semantic::Positions), points),
            (Valid(Semantic::Normals), normals),
            (Valid(Semantic::Joints(0)), joints),
            (Valid(Semantic::Weights(0)), weights),
        ]);
        let mut primitives = Vec::new();
        for (color, indices) in painted {
            let corners: Vec<u8> = indices.iter().flat_map(|i| i.to_le_bytes()).collect();
            let target = Some(Target::ElementArrayBuffer);
            let corners = self.accessor(&corners, ComponentType::U32, Type::Scalar, indices.len(), target);
            primitives.push(json::mesh::Primitive {
                attributes: attributes.clone(),
                extensions: None,
                extras: Default::default(),
                indices: Some(corners),
                material: Some(self.material(color)),
                mode: Valid(json::mesh::Mode::Triangles),
                targets: None,
            });
        }
        let mesh = self.root.push(json::Mesh {
            extensions: None,
            extras: Default::default(),
            name: Some(name.into()),
            primitives,
            weights: None,
        });
        let binds: Vec<f32> = zero
            .world
            .iter()
            .flat_map(|world| {
                let matrix = world.inverse().to_homogeneous();
                matrix.iter().map(|&x| x as f32).collect::<Vec<_>>() // columns, as glTF
            })
            .collect();
        let count = zero.world.len();
        let binds = self.floats(&binds, Type::Mat4, count, None);
        let skin = self.root.push(json::Skin {
            extensions: None,
            extras: Default::default(),
            inverse_bind_matrices: Some(binds),
            joints: (0..count as u32).map(Index::new).collect(),
            name: Some(name.into()),
            skeleton: Some(Index::new(0)),
        });
        self.root.push(json::Node {
            name: Some(format!("{name} body")),
            mesh: Some(mesh),
            skin: Some(skin),
            ..Default::default()
        })
    }

    /// A key per frame for every joint that moves.
    fn animation(&mut self, clip: &Clip, name: &str) -> Result<(), GlbError> {
        let frames = clip.frames();
        let times: Vec<f32> = (0..frames).map(|i| (i as f64 / clip.rate_hz) as f32).collect();
        if times.windows(2).any(|t| t[0] >= t[1]) || times.iter().any(|t| !t.is_finite()) {
            return Err(GlbError::TooLong { frames, rate_hz: clip.rate_hz });
        }
        let (Some(&first), Some(&last)) = (times.first(), times.last()) else { return Ok(()) };
        let input = self.floats(&times, Type::Scalar, frames, None);
        self.root.accessors[input.value()].min = Some(json::Value::from(vec![first]));
        self.root.accessors[input.value()].max = Some(json::Value::from(vec![last]));

        let (mut samplers, mut channels) = (Vec::new(), Vec::new());
        let mut channel = |link: usize, path: Property, output: Index<json::Accessor>| {
            channels.push(json::animation::Channel {
                sampler: Index::new(samplers.len() as u32),
                target: json::animation::Target {
                    extensions: None,
                    extras: Default::default(),
                    node: Index::new(link as u32),
                    path: Valid(path),
                },
                extensions: None,
                extras: Default::default(),
            });
            samplers.push(json::animation::Sampler {
                extensions: None,
                extras: Default::default(),
                input,
                interpolation: Valid(Interpolation::Linear),
                output,
            });
        };
        for (i, link) in clip.skeleton.links().iter().enumerate() {
            let (mut places, mut turns) = (Vec::with_capacity(frames), Vec::with_capacity(frames));
            let mut before = link.parent_from_zero.rotation.coords;
            for frame in 0..frames {
                let local = link.parent_from_zero * clip.skeleton.joint_transform(clip.pose(frame), i);
                let coords = local.rotation.coords; // x y z w, as glTF
                before = if coords.dot(&before) < 0.0 { -coords } else { coords };
                let turn: [f32; 4] = before.map(|x| x as f32).into();
                let place = vec3(&local.translation.vector);
                if !turn.iter().chain(&place).all(|x| x.is_finite()) {
                    return Err(GlbError::NotFinite { frame, link: link.name.clone() });
                }
                turns.push(turn);
                places.push(place);
            }
            if matches!(link.joint, Joint::Free | Joint::Prismatic(_)) {
                channel(
                    i,
                    Property::Translation,
                    self.floats(places.as_flattened(), Type::Vec3, frames, None),
                );
            }
            if matches!(link.joint, Joint::Free | Joint::Spherical | Joint::Revolute(_)) {
                channel(i, Property::Rotation, self.floats(turns.as_flattened(), Type::Vec4, frames, None));
            }
        }
        if channels.is_empty() {
            // Nothing moves; an animation without channels is not allowed, nor are keys nobody uses.
            self.root.accessors.pop();
            if let Some(view) = self.root.buffer_views.pop() {
                self.bytes.truncate(view.byte_offset.map_or(0, |at| at.0 as usize));
            }
            return Ok(());
        }
        self.root.push(json::Animation {
            extensions: None,
            extras: Default::default(),
            channels,
            name: Some(name.into()),
            samplers,
        });
        Ok(())
    }

    fn floats(
        &mut self,
        data: &[f32],
        type_: Type,
        count: usize,
        target: Option<Target>,
    ) -> Index<json::Accessor> {
        let bytes: Vec<u8> = data.iter().flat_map(|x| x.to_le_bytes()).collect();
        self.accessor(&bytes, ComponentType::F32, type_, count, target)
    }

    /// Appends data in a view of its own; all element sizes here are multiples of four bytes.
    fn accessor(
        &mut self,
        data: &[u8],
        component: ComponentType,
        type_: Type,
        count: usize,
        target: Option<Target>,
    ) -> Index<json::Accessor> {
        let view = self.root.push(json::buffer::View {
            buffer: Index::new(0),
            byte_length: USize64::from(data.len()),
            byte_offset: Some(USize64::from(self.bytes.len())),
            byte_stride: None,
            extensions: None,
            extras: Default::default(),
            name: None,
            target: target.map(Valid),
        });
        self.bytes.extend_from_slice(data);
        self.root.push(json::Accessor {
            buffer_view: Some(view),
            byte_offset: None,
            component_type: Valid(GenericComponentType(component)),
            count: USize64::from(count),
            extensions: None,
            extras: Default::default(),
            max: None,
            min: None,
            name: None,
            normalized: false,
            sparse: None,
            type_: Valid(type_),
        })
    }

    fn finish(mut self, links: usize) -> Result<Vec<u8>, GlbError> {
        if !self.bytes.is_empty() {
            self.root.push(json::Buffer {
                byte_length: USize64::from(self.bytes.len()),
                extensions: None,
                extras: Default::default(),
                name: None,
                uri: None,
            });
        }
        let text = json::serialize::to_vec(&self.root)
            .map_err(|e| GlbError::Encode { what: "the glTF document", message: e.to_string() })?;
        let bytes = text.len() + self.bytes.len() + 64;
        if u32::try_from(bytes).is_err() {
            return Err(GlbError::TooLarge { bytes, links });
        }
        let glb = gltf::binary::Glb {
            // The length is computed when written.
            header: gltf::binary::Header { magic: *b"glTF", version: 2, length: 0 },
            json: Cow::Owned(text),
            bin: (!self.bytes.is_empty()).then_some(Cow::Owned(self.bytes)),
        };
        glb.to_vec().map_err(|e| GlbError::Encode { what: "the GLB container", message: e.to_string() })
    }
}

fn vec3(v: &Vec3) -> [f32; 3] {
    [v.x as f32, v.y as f32, v.z as f32]
}

/// Least and greatest components, of the floats as they are stored.
fn bounds(points: &[[f32; 3]]) -> (json::Value, json::Value) {
    let (mut lo, mut hi) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for p in points {
        for k in 0..3 {
            lo[k] = lo[k].min(p[k]);
            hi[k] = hi[k].max(p[k]);
        }
    }
    (json::Value::from(lo.to_vec()), json::Value::from(hi.to_vec()))
}
