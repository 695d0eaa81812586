//! Where sites of a character are, frame by frame.

use bodies::Character;
use motion::Clip;

use crate::Puppet;
use crate::phase::Path;

/// World positions of the contact points in every frame, one path per point.
pub fn point_paths(puppet: &Puppet, clip: &Clip) -> Vec<Path> {
    let sites: Vec<usize> = puppet.contacts.iter().map(|c| c.site).collect();
    site_paths(&puppet.character, &sites, clip)
}

/// World positions of some sites of a character in every frame, one path per site.
pub(crate) fn site_paths(character: &Character, sites: &[usize], clip: &Clip) -> Vec<Path> {
    let all = character.skeleton.sites();
    let mut k = motion::Kinematics::new(&clip.skeleton, &clip.skeleton.zero_pose());
    let mut out = vec![Path::with_capacity(clip.frames()); sites.len()];
    for i in 0..clip.frames() {
        k.update(&clip.skeleton, clip.pose(i));
        for (path, &site) in out.iter_mut().zip(sites) {
            path.push(k.point(all[site].link, &all[site].at));
        }
    }
    out
}
