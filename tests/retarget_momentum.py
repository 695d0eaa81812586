#!/usr/bin/env python3
"""Has a retargeted clip the horizontal momentum of the human's, scaled?

Recomputes both momenta from the files that `contrapposto retarget` wrote, human.bvh and retargeted.bvh, and from the
masses and centres of mass of both bodies as `contrapposto convert BODY body.xml` writes them (MJCF):

  momentum    P[k] = m (c[k] - c[k-1]) * rate, c the centre of mass by forward kinematics of the BVH
  scaled      M_R R S R^T P_human, M_R the ratio of the masses, S = diag(s_x, s_z) the size ratios that report.json
              names, R the turn to the human's slow heading: of the root's +Z, turned upright, below 0.25 Hz

The mean over the horizontal |scaled - character|^2 over that of |scaled|^2, its root, is the mismatch. The two size
ratios are often equal; the heading then cancels. The low-pass here is a Gaussian, not the one of the program.

Python standard library only; shares no code with what wrote the files.
Exit code: 0 within the threshold, 1 beyond it, 2 for files that cannot be judged.
"""

import argparse
import json
import math
import sys
import xml.etree.ElementTree as ElementTree

IDENTITY = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
CUTOFF_HZ = 0.25


def times(a, b):
    return tuple(tuple(sum(a[i][k] * b[k][j] for k in range(3)) for j in range(3)) for i in range(3))


def turned(a, v):
    return tuple(sum(a[i][k] * v[k] for k in range(3)) for i in range(3))


def plus(a, b):
    return tuple(x + y for x, y in zip(a, b))


def about(axis, degrees):
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    if axis == "X":
        return ((1, 0, 0), (0, c, -s), (0, s, c))
    if axis == "Y":
        return ((c, 0, s), (0, 1, 0), (-s, 0, c))
    return ((c, -s, 0), (s, c, 0), (0, 0, 1))


def of_quaternion(w, x, y, z):
    return (
        (1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
        (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
        (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
    )


class Bvh:
    """Joints as (name, parent, offset, channels), and frames of numbers, metres per unit 0.01."""

    def __init__(self, path):
        words = open(path, encoding="utf-8").read().split()
        self.joints, open_joints, at = [], [], 0
        while words[at] != "MOTION":
            word = words[at]
            if word in ("ROOT", "JOINT"):
                self.joints.append([words[at + 1], open_joints[-1] if open_joints else None, None, []])
                open_joints.append(len(self.joints) - 1)
                at += 3
            elif word == "End":
                open_joints.append(None)
                at += 3
            elif word == "OFFSET":
                if open_joints[-1] is not None:
                    self.joints[open_joints[-1]][2] = tuple(0.01 * float(x) for x in words[at + 1:at + 4])
                at += 4
            elif word == "CHANNELS":
                count = int(words[at + 1])
                self.joints[open_joints[-1]][3] = words[at + 2:at + 2 + count]
                at += 2 + count
            elif word == "}":
                open_joints.pop()
                at += 1
            else:
                at += 1
        frames = int(words[at + 2])
        self.rate = 1.0 / float(words[at + 5])
        numbers = [float(x) for x in words[at + 6:]]
        width = sum(len(j[3]) for j in self.joints)
        if len(numbers) != frames * width:
            raise ValueError(f"{path}: {len(numbers)} numbers for {frames} frames of {width} channels")
        self.frames = [numbers[i * width:(i + 1) * width] for i in range(frames)]

    def placed(self, frame):
        """Position and rotation of every joint."""
        out, at = [], 0
        for _, parent, offset, channels in self.joints:
            move, turn = [0.0, 0.0, 0.0], IDENTITY
            for channel in channels:
                if channel.endswith("position"):
                    move["XYZ".index(channel[0])] = 0.01 * frame[at]
                else:
                    turn = times(turn, about(channel[0], frame[at]))
                at += 1
            p, r = ((0.0, 0.0, 0.0), IDENTITY) if parent is None else out[parent]
            out.append((plus(p, turned(r, plus(offset, move))), times(r, turn)))
        return out


def masses(path):
    """Of each body its mass and its centre along the world's axes in the zero pose, as a BVH joint carries it."""
    out = {}

    def walk(body, rotation):
        quat = body.get("quat")
        if quat:
            rotation = times(rotation, of_quaternion(*(float(x) for x in quat.split())))
        hinge = body.find("joint[@type='hinge']")
        if hinge is not None and hinge.get("ref"):
            # the body lies as it stands, its hinge at `ref` (rad): back to the zero pose
            half = -0.5 * float(hinge.get("ref"))
            x, y, z = (float(a) for a in hinge.get("axis").split())
            s = math.sin(half) / math.sqrt(x * x + y * y + z * z)
            rotation = times(rotation, of_quaternion(math.cos(half), s * x, s * y, s * z))
        inertial = body.find("inertial")
        if inertial is not None:
            centre = tuple(float(x) for x in inertial.get("pos").split())
            out[body.get("name")] = (float(inertial.get("mass")), turned(rotation, centre))
        for child in body.findall("body"):
            walk(child, rotation)

    for body in ElementTree.parse(path).getroot().find("worldbody").findall("body"):
        walk(body, IDENTITY)
    return out


def centres(bvh, bodies):
    """Centre of mass in every frame, and the whole mass."""
    names = {joint[0]: i for i, joint in enumerate(bvh.joints)}
    missing = [name for name in bodies if name not in names]
    if missing:
        raise ValueError(f"bodies that the clip has no joint of: {', '.join(missing)}")
    whole, out = sum(m for m, _ in bodies.values()), []
    for frame in bvh.frames:
        placed, sum_ = bvh.placed(frame), (0.0, 0.0, 0.0)
        for name, (mass, centre) in bodies.items():
            p, r = placed[names[name]]
            at = plus(p, turned(r, centre))
            sum_ = plus(sum_, tuple(mass * x for x in at))
        out.append(tuple(x / whole for x in sum_))
    return out, whole


def upright_heading(r):
    """Turn about Y of +Z once the shortest turn that makes the root's +Y vertical is taken away."""
    up, front = (r[0][1], r[1][1], r[2][1]), (r[0][2], r[1][2], r[2][2])
    # the shortest turn from `up` to Y: about up x Y
    axis = (-up[2], 0.0, up[0])
    cos, scale = up[1], 1.0 / (1.0 + up[1])
    dot = sum(a * b for a, b in zip(axis, front))
    cross = (
        axis[1] * front[2] - axis[2] * front[1],
        axis[2] * front[0] - axis[0] * front[2],
        axis[0] * front[1] - axis[1] * front[0],
    )
    front = tuple(f * cos + c + a * dot * scale for f, c, a in zip(front, cross, axis))
    return math.atan2(front[0], front[2])


def course(bvh):
    """The slow heading in every frame, rad."""
    headings = []
    for frame in bvh.frames:
        h = upright_heading(bvh.placed(frame)[0][1])
        if headings:
            h += math.tau * round((headings[-1] - h) / math.tau)
        headings.append(h)
    # a Gaussian passes half at the cutoff
    sigma = math.sqrt(2.0 * math.log(2.0)) / (math.tau * CUTOFF_HZ) * bvh.rate
    reach, n = math.ceil(4 * sigma), len(headings)
    weights = [math.exp(-0.5 * (i / sigma) ** 2) for i in range(-reach, reach + 1)]

    def beyond(i):
        # ends go on as they are seen from there: point reflection
        if i < 0:
            return 2 * headings[0] - headings[min(-i, n - 1)]
        if i >= n:
            return 2 * headings[-1] - headings[max(2 * (n - 1) - i, 0)]
        return headings[i]

    return [
        sum(w * beyond(k + i - reach) for i, w in enumerate(weights)) / sum(weights) for k in range(n)
    ]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", help="what `contrapposto retarget … --stop-after global` wrote")
    parser.add_argument("human", help="MJCF of the human body")
    parser.add_argument("character", help="MJCF of the character")
    parser.add_argument("--max-percent", type=float, default=1.0, metavar="PERCENT")
    args = parser.parse_args()
    try:
        report = json.load(open(f"{args.folder}/report.json", encoding="utf-8"))
        sizes = report["momentum"]["size_ratio"]
        human, own = Bvh(f"{args.folder}/human.bvh"), Bvh(f"{args.folder}/retargeted.bvh")
        theirs, human_mass = centres(human, masses(args.human))
        ours, own_mass = centres(own, masses(args.character))
        if len(theirs) != len(ours) or abs(human.rate - own.rate) > 1e-6 * human.rate:
            raise ValueError("the clips have different frames")
    except (OSError, ValueError, KeyError, IndexError, ElementTree.ParseError) as fault:
        print(f"error: {fault}", file=sys.stderr)
        return 2
    slow = course(human)
    missed = whole = 0.0
    for k in range(1, len(ours)):
        angle = 0.5 * (slow[k - 1] + slow[k])
        sin, cos = math.sin(angle), math.cos(angle)
        x, z = theirs[k][0] - theirs[k - 1][0], theirs[k][2] - theirs[k - 1][2]
        side, ahead = sizes[0] * (cos * x - sin * z), sizes[2] * (sin * x + cos * z)
        scaled = (cos * side + sin * ahead, cos * ahead - sin * side)
        moved = (ours[k][0] - ours[k - 1][0], ours[k][2] - ours[k - 1][2])
        missed += (scaled[0] - moved[0]) ** 2 + (scaled[1] - moved[1]) ** 2
        whole += scaled[0] ** 2 + scaled[1] ** 2
    if whole == 0.0:
        print("error: the human does not move", file=sys.stderr)
        return 2
    # both are times the same mass: scaled = M_R m_human v, and M_R is own_mass / human_mass
    ratio = abs(report["momentum"]["mass_ratio"] * human_mass / own_mass - 1.0)
    percent = 100.0 * math.sqrt(missed / whole)
    good = percent <= args.max_percent and ratio < 1e-6
    print(f"horizontal momentum missed by {percent:.4f} % RMS of the scaled human's, mass ratio by {ratio:.1e}: "
          f"{'good' if good else 'BAD'}")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
