//! Traces as `trace.npz`: plain numpy arrays, readable without pickle and without this project.
//!
//! In: a [`Trace`](dynamics::Trace). Out: an uncompressed zip of `.npy` arrays; and back. Same trace, same bytes: time
//! stamps are fixed. What is read equals what was written to the bit, but for the wall time, which is
//! left out. Reading trusts nothing: see [`TraceFileError`].
//!
//! Layout (`n` rows, `L` links, `c` contacts; `q` and `v` as in [`motion::skeleton`]):
//!
//! | array | shape | holds |
//! |---|---|---|
//! | `rate_hz`, `substeps`, `ground_m` | scalar | as in [`Trace`](dynamics::Trace); `ground_m` is NaN without ground |
//! | `gravity` | 3 | m/s² |
//! | `root_mode` | scalar text | `free`, `assisted` or `pinned` |
//! | `root_limit` | 2 | budget, N and N·m: zero when free, infinite when pinned |
//! | `q`, `target` | n × nq | poses; lengths in m, angles in rad, quaternions `w x y z` |
//! | `v`, `torque`, `stop_torque`, `k_lo`, `k_hi`, `kd` | n × nv | as in [`Trace`](dynamics::Trace) |
//! | `root_wrench`, `momentum` | n × 6 | as in [`Trace`](dynamics::Trace) |
//! | `com` | n × 3 | m |
//! | `energy` | n × 2 | J |
//! | `link_com` | n × 3L | world centres of mass, m; absent when not recorded |
//! | `ground_up` | 3 or rows × 3 | direction in which the ground faces, in all rows or in each; absent when it is level |
//! | `disturbed_wrench` | n × 6 | pushes, and hands that give and take masses: N, N·m about the root's origin; absent without |
//! | `root_correction` | n × 7 | what the engine put on the root for the momentum's sake: N·s, N·m·s about the root's origin, J; absent of engines that do not |
//! | `carried_link`, `carried_mass` | k | index, kg: masses carried; these arrays are absent without |
//! | `carried_at`, `carried_inertia` | k × 3, k × 9 | centre in the link's frame, m; kg·m² about it |
//! | `carried_rows` | k × 2 | first row whose forces move it, first row whose forces do so no more |
//! | `carried_com` | n × 3k | world centres, m |
//! | `contact_row`, `contact_link` | c | indices |
//! | `contact_point`, `contact_force` | c × 3 | m, N |
//! | `contact_depth` | c | m |
//! | `contact_against` | c | −1 the ground, −2 − p the prop p, else the other link; absent where all are of the ground |
//! | `prop_name`, `prop_friction` | p | text; Coulomb's coefficient; these arrays are absent without props |
//! | `prop_half`, `prop_place` | p × 3, p × 7 | half edges, m; centre (m), quaternion `w x y z`: `world_from_prop` |
//! | `plan_point` | p | text: points that were to stand, by limb, link or site; these arrays are absent without |
//! | `plan_span` | p × 2 | first and last moment, s |
//! | `plan_place` | p × 7 | where: position (m), quaternion `w x y z`; NaN where that is not known |
//! | `link_name`, `joint_type` | L | text |
//! | `link_parent` | L | −1 for the root |
//! | `link_mass`, `link_com_local`, `link_inertia` | L, L × 3, L × 9 | kg; m, kg·m², link frame |
//! | `link_offset` | L × 7 | `parent_from_zero`: position (m), quaternion `w x y z` |
//! | `joint_axis` | L × 3 | of hinges and slides; zero for others |
//! | `joint_q_at`, `joint_v_at` | L | first column of the joint in `q` and `v` |
//! | `dof_name` | nv | text: the link's name, with `.rx` and the like where a joint has several |
//! | `character_name` | scalar text | name of the body |
//! | `joint_class` | L | text: `root`, `spine`, `knee` and the like |
//! | `limit_axes` | L × 9 | of balls: two swing axes and the twist axis, zero frame; NaN for others |
//! | `limit_range` | L × 6 | least and greatest of the joint's value (hinge, slide) or of its three coordinates (ball), rad or m; NaN without limit |
//! | `link_end` | L × 3 | where a drawn bone without children ends, link frame, m; NaN for others |
//! | `link_color` | L × 3 | red, green, blue, 0 to 255; −1 of links without a colour; absent where none has one |
//! | `rest` | nq | pose of rest |
//! | `shape_link`, `shape_type` | s | index; text: `capsule`, `box`, `sphere`, `cone` |
//! | `shape_size` | s × 10 | link frame, m: capsule: ends (6), radius; sphere: centre (3), radius; box: centre (3), half edges (3), quaternion `w x y z`; cone: ends (6), their radii (2); zero beyond |
//! | `site_name`, `site_link`, `site_at` | k, k, k × 3 | text, index, link frame (m): named points |
//! | `contact_site` | – | indices of the sites that may touch the ground |
//! | `limb_name`, `limb_kind`, `limb_links` | m, m, m × 3 | text; text: `arm`, `leg`; upper, lower and end link |
//! | `part_name`, `part_links` | p, p × L | text; 1 where the link belongs to the part |
//! | `units` | u × 2 | text: array, unit |
//!
//! Format: numpy `lib.format` 1.0; text is fixed-width UTF-32 (`<U`).

mod body;
mod npy;
mod read;
mod write;

pub(crate) use read::Arrays as ArraysIn;
pub use read::{TraceFileError, open, read};
pub(crate) use write::Arrays;
pub use write::{save, write};
