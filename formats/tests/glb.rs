//! GLB: read back by the `gltf` crate, nodes and vertices stand where our kinematics puts them.

use std::path::Path;
use std::sync::Arc;

use formats::bvh::{ImportOptions, read_file};
use formats::glb::{GlbError, bones, write};
use gltf::animation::util::ReadOutputs;
use motion::rotation::exp;
use motion::{Clip, Joint, Kinematics, Link, Shape, Skeleton, Transform, Vec3};
use nalgebra::{Matrix4, Point3, Quaternion, Translation3, UnitQuaternion, Vector4};

fn cmu(name: &str) -> Clip {
    let path = support::shared(&format!("mocap/bvh/{name}"));
    read_file(&path, &ImportOptions::default()).unwrap().0
}

/// All joint kinds, turned zero frames.
fn odd_clip() -> Clip {
    let axis = Vec3::new(1.0, 2.0, -0.5).normalize();
    let joints = [
        Joint::Free,
        Joint::Spherical,
        Joint::Prismatic(axis),
        Joint::Fixed,
        Joint::Revolute(axis),
        Joint::Free,
    ];
    let links = joints.iter().enumerate().map(|(i, &joint)| {
        let mut link = Link::new(format!("link {i}"), i.checked_sub(1), Vec3::zeros(), joint);
        let turn = exp(&Vec3::new(0.3, i as f64, -0.7));
        link.parent_from_zero = Transform::from_parts(Translation3::new(0.1, 0.4, 0.2), turn);
        link
    });
    let skeleton = Arc::new(Skeleton::new(links.collect()).unwrap());
    let mut q = Vec::new();
    for frame in 0..60 {
        let t = f64::from(frame) * 0.2;
        let mut pose = skeleton.zero_pose();
        for (i, link) in skeleton.links().iter().enumerate() {
            // a full turn and more, so that quaternions would change sign
            let mut turn = exp(&Vec3::new(t, 0.2, -0.4 * t));
            if frame % 2 == 1 {
                turn = UnitQuaternion::new_unchecked(-turn.into_inner());
            }
            match link.joint {
                Joint::Free | Joint::Spherical => skeleton.set_rotation(&mut pose, i, &turn),
                Joint::Revolute(_) | Joint::Prismatic(_) => pose[skeleton.q_at(i)] = t.sin(),
                Joint::Fixed => {}
            }
            if link.joint == Joint::Free {
                skeleton.set_position(&mut pose, i, &Vec3::new(t, t.cos(), -0.5));
            }
        }
        q.extend(pose);
    }
    Clip::new(skeleton, 50.0, q)
}

fn odd_solids() -> Vec<(usize, Shape)> {
    let center = Vec3::new(0.1, 0.0, 0.05);
    vec![
        (0, Shape::Box { center, half: Vec3::new(0.1, 0.2, 0.15), rotation: exp(&Vec3::new(0.2, 0.1, 0.9)) }),
        (2, Shape::Sphere { center, radius: 0.1 }),
        (5, Shape::Capsule { a: Vec3::zeros(), b: center * 3.0, radius: 0.04 }),
    ]
}

/// A document whose pose can be set from its animation.
struct Document {
    gltf: gltf::Gltf,
    parents: Vec<Option<usize>>,
}

impl Document {
    fn read(bytes: &[u8]) -> Self {
        let gltf = gltf::Gltf::from_slice(bytes).unwrap();
        let mut parents = vec![None; gltf.nodes().count()];
        for node in gltf.nodes() {
            for child in node.children() {
                parents[child.index()] = Some(node.index());
            }
        }
        Self { gltf, parents }
    }

    fn bin(&self) -> &[u8] {
        self.gltf.blob.as_deref().unwrap()
    }

    /// World matrices of all nodes at a key of the animation.
    fn world(&self, key: usize) -> Vec<Matrix4<f64>> {
        let mut local: Vec<([f32; 3], [f32; 4])> = self
            .gltf
            .nodes()
            .map(|node| {
                let (translation, rotation, scale) = node.transform().decomposed();
                assert_eq!(scale, [1.0; 3]);
                (translation, rotation)
            })
            .collect();
        for channel in self.gltf.animations().flat_map(|a| a.channels().collect::<Vec<_>>()) {
            let node = channel.target().node().index();
            match channel.reader(|_| Some(self.bin())).read_outputs().unwrap() {
                ReadOutputs::Translations(mut keys) => local[node].0 = keys.nth(key).unwrap(),
                ReadOutputs::Rotations(keys) => local[node].1 = keys.into_f32().nth(key).unwrap(),
                _ => panic!("neither moved nor turned"),
            }
        }
        let mut world: Vec<Matrix4<f64>> = Vec::new();
        for (i, (t, r)) in local.iter().enumerate() {
            let [x, y, z, w] = r.map(f64::from);
            let turn = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
            let place = Translation3::from(Vec3::from(t.map(f64::from)));
            let own = Transform::from_parts(place, turn).to_homogeneous();
            world.push(self.parents[i].map_or(own, |p| world[p] * own));
        }
        world
    }
}

#[test]
fn nodes_read_back_stand_where_kinematics_says() {
    let mut worst = 0.0f64;
    for (clip, solids) in [
        (cmu("02_01.bvh"), bones(&cmu("02_01.bvh").skeleton)),
        (cmu("49_07.bvh"), Vec::new()),
        (odd_clip(), odd_solids()),
    ] {
        let document = Document::read(&write(&clip, &solids, &[], "test").unwrap());
        for frame in [0, 1, clip.frames() / 3, clip.frames() / 2, clip.frames() - 1] {
            let ours = Kinematics::new(&clip.skeleton, clip.pose(frame));
            let theirs = document.world(frame);
            for (i, link) in clip.skeleton.links().iter().enumerate() {
                let error = (ours.world[i].to_homogeneous() - theirs[i]).amax();
                worst = worst.max(error);
                assert!(error < 1e-5, "{} {frame}: {error}", link.name);
            }
        }
        let names: Vec<_> = document.gltf.nodes().map(|n| n.name().unwrap().to_owned()).collect();
        for (link, name) in clip.skeleton.links().iter().zip(names) {
            assert_eq!(link.name, name);
        }
    }
    assert!(worst < 1e-6, "{worst}"); // m or 1; 2.3e-7 seen
}

#[test]
fn skinned_vertices_follow_their_links() {
    let (clip, solids) = (odd_clip(), odd_solids());
    let document = Document::read(&write(&clip, &solids, &[], "test").unwrap());
    let skin = document.gltf.skins().next().unwrap();
    let binds: Vec<Matrix4<f64>> = skin
        .reader(|_| Some(document.bin()))
        .read_inverse_bind_matrices()
        .unwrap()
        .map(|m| Matrix4::from_columns(&m.map(|c| Vector4::from(c.map(f64::from)))))
        .collect();
    assert_eq!(binds.len(), clip.skeleton.links().len());
    let primitive = document.gltf.meshes().next().unwrap().primitives().next().unwrap();
    let reader = primitive.reader(|_| Some(document.bin()));
    let points: Vec<[f32; 3]> = reader.read_positions().unwrap().collect();
    let joints: Vec<[u16; 4]> = reader.read_joints(0).unwrap().into_u16().collect();
    assert!(reader.read_weights(0).unwrap().into_f32().all(|w| w == [1.0, 0.0, 0.0, 0.0]));
    assert!(reader.read_indices().unwrap().into_u32().all(|i| (i as usize) < points.len()));

    let mut worst = 0.0f64;
    // Distance of a skinned vertex from its solid's surface, with the link where our kinematics has it.
    for frame in [0, 7, 59] {
        let ours = Kinematics::new(&clip.skeleton, clip.pose(frame));
        let theirs = document.world(frame);
        for (point, joint) in points.iter().zip(&joints) {
            let link = joint[0] as usize;
            let bound = Vector4::new(point[0].into(), point[1].into(), point[2].into(), 1.0);
            let world = theirs[link] * binds[link] * bound;
            let local = ours.world[link].inverse() * Point3::new(world.x, world.y, world.z);
            let distance = match solids.iter().find(|(l, _)| *l == link).unwrap().1 {
                Shape::Sphere { center, radius } => (local.coords - center).norm() - radius,
                Shape::Capsule { a, b, radius } => {
                    let along = ((local.coords - a).dot(&(b - a)) / (b - a).norm_squared()).clamp(0.0, 1.0);
                    (local.coords - a - (b - a) * along).norm() - radius
                }
                // vertices lie on the two flat ends
                Shape::Cone { a, b, .. } => {
                    let axis = (b - a).normalize();
                    let along = (local.coords - a).dot(&axis);
                    along.abs().min((along - (b - a).norm()).abs())
                }
                Shape::Box { center, half, rotation } => {
                    (rotation.inverse() * (local.coords - center)).abs().component_div(&half).max() - 1.0
                }
            };
            worst = worst.max(distance.abs());
            assert!(distance.abs() < 2e-5, "{frame} {link}: {distance}");
        }
    }
    assert!(worst < 5e-6, "{worst}"); // m; 2.0e-6 seen, floats of metres
}

#[test]
fn stored_bounds_signs_and_alignment_are_right() {
    let bytes = write(&odd_clip(), &odd_solids(), &[], "test").unwrap();
    assert_eq!(bytes.len() % 4, 0);
    assert_eq!(u32::from_le_bytes(bytes[8..12].try_into().unwrap()) as usize, bytes.len());
    let document = Document::read(&bytes);
    for view in document.gltf.views() {
        assert_eq!(view.offset() % 4, 0);
    }
    let mut rotations = 0;
    for channel in document.gltf.animations().next().unwrap().channels() {
        let reader = channel.reader(|_| Some(document.bin()));
        let times: Vec<f32> = reader.read_inputs().unwrap().collect();
        assert_eq!(times.len(), 60);
        assert_eq!(times[59], 1.18);
        let input = channel.sampler().input();
        assert_eq!(input.max().unwrap().get(0).unwrap().as_f64().unwrap(), f64::from(times[59]));
        if let ReadOutputs::Rotations(keys) = reader.read_outputs().unwrap() {
            let keys: Vec<[f32; 4]> = keys.into_f32().collect();
            for pair in keys.windows(2) {
                let dot: f32 = (0..4).map(|k| pair[0][k] * pair[1][k]).sum();
                assert!(dot > 0.9, "{dot}");
            }
            rotations += 1;
        }
    }
    assert_eq!(rotations, 4); // two free, a ball, a hinge
    let primitive = document.gltf.meshes().next().unwrap().primitives().next().unwrap();
    let points = primitive.reader(|_| Some(document.bin())).read_positions().unwrap();
    let bounds = primitive.bounding_box();
    for k in 0..3 {
        let (lo, hi) = points.clone().fold((f32::MAX, f32::MIN), |(lo, hi), p| (lo.min(p[k]), hi.max(p[k])));
        assert_eq!((bounds.min[k], bounds.max[k]), (lo, hi));
    }
}

#[test]
fn the_same_clip_gives_the_same_bytes() {
    let clip = odd_clip();
    assert_eq!(
        write(&clip, &odd_solids(), &[], "a").unwrap(),
        write(&clip, &odd_solids(), &[], "a").unwrap()
    );
}

#[test]
fn what_gltf_cannot_hold_is_refused() {
    let clip = odd_clip();
    let ball = |radius: f64| Shape::Sphere { center: Vec3::zeros(), radius };
    assert!(matches!(
        write(&clip, &[(6, ball(1.0))], &[], "x"),
        Err(GlbError::Link { link: 6, links: 6, .. })
    ));
    for radius in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let error = write(&clip, &[(3, ball(radius))], &[], "x").unwrap_err().to_string();
        assert_eq!(error, "solid 0 on `link 3` has a radius or edge that is not a positive number");
    }
    let mut broken = clip.clone();
    broken.pose_mut(4)[0] = f64::NAN;
    assert!(matches!(write(&broken, &[], &[], "x"), Err(GlbError::NotFinite { frame: 4, .. })));
    let rooted =
        Skeleton::new(vec![Link::new("post", None, Vec3::zeros(), Joint::Revolute(Vec3::y()))]).unwrap();
    let long = Clip::new(Arc::new(rooted), 1e3, vec![0.0; 20_000_000]);
    assert!(matches!(write(&long, &[], &[], "x"), Err(GlbError::TooLong { .. })));
}

/// Files for a validator: `GLB_OUT=folder cargo test -p motion --test glb`.
#[test]
fn files_are_written_where_asked() {
    let kept = std::env::var("GLB_OUT").ok();
    let folder = tempfile::tempdir().unwrap();
    let folder = kept.as_deref().map_or(folder.path(), Path::new);
    let walk = cmu("02_01.bvh");
    let still = Clip::new(walk.skeleton.clone(), 120.0, walk.pose(0).to_vec());
    for (name, clip, solids) in [
        ("walk", &walk, bones(&walk.skeleton)),
        ("naked", &walk, Vec::new()),
        ("still", &still, bones(&walk.skeleton)),
        ("odd", &odd_clip(), odd_solids()),
    ] {
        let path = folder.join(format!("{name}.glb"));
        formats::glb::write_file(&path, clip, &solids, &[], name).unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), write(clip, &solids, &[], name).unwrap());
    }
}
