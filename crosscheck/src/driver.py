"""MuJoCo behind a pipe: the other engine of `contrapposto crosscheck`.

Requests and answers on stdin and stdout: u32 length of a JSON head, the head, u32 count of f64, the numbers
(little endian). Layouts and frames of the numbers are MuJoCo's; the Rust side converts. One answer per request;
an answer with "error" in its head is a failure.

The actuator law is written here a second time, on purpose: hinges by native `general` actuators, balls and stops
in the control callback, which MuJoCo calls in every stage of its Runge-Kutta integrator.
"""

import json
import struct
import sys
from xml.etree import ElementTree

import mujoco
import numpy as np

OUT = sys.stdout.buffer
IN = sys.stdin.buffer


def receive():
    head = IN.read(4)
    if len(head) < 4:
        sys.exit(0)
    request = json.loads(IN.read(struct.unpack("<I", head)[0]))
    count = struct.unpack("<I", IN.read(4))[0]
    return request, np.frombuffer(IN.read(8 * count), dtype="<f8")


def answer(head, numbers=()):
    text = json.dumps(head).encode()
    data = np.ascontiguousarray(numbers, dtype="<f8").ravel()
    OUT.write(struct.pack("<I", len(text)) + text + struct.pack("<I", data.size) + data.tobytes())
    OUT.flush()


# quaternions w x y z and vectors, one per row


def conj(q):
    return q * np.array([1.0, -1.0, -1.0, -1.0])


def dot(a, b):
    return (a * b).sum(1)


def cross(a, b):
    return a[:, [1, 2, 0]] * b[:, [2, 0, 1]] - a[:, [2, 0, 1]] * b[:, [1, 2, 0]]


def mul(a, b):
    w, v, x, u = a[:, :1], a[:, 1:], b[:, :1], b[:, 1:]
    return np.concatenate((w * x - dot(v, u)[:, None], w * u + x * v + cross(v, u)), 1)


def rotate(q, x):
    t = 2.0 * cross(q[:, 1:], x)
    return x + q[:, :1] * t + cross(q[:, 1:], t)


def log(q):
    """Rotation vectors, at most half a turn."""
    q = np.where(q[:, :1] < 0.0, -q, q)
    s = np.sqrt(dot(q[:, 1:], q[:, 1:]))
    small = s < 1e-12
    scale = np.where(small, 2.0, 2.0 * np.arctan2(s, q[:, 0]) / np.where(small, 1.0, s))
    return q[:, 1:] * scale[:, None]


def unjacobian(d, s):
    """J(d)^-T s, J the left Jacobian of the exponential map."""
    a = np.sqrt(dot(d, d))
    small = a < 1e-4
    x = np.where(small, 1.0, a)
    c = np.where(small, 1.0 / 12.0, 1.0 / x**2 - (1.0 + np.cos(x)) / (2.0 * x * np.sin(x)))
    once = cross(d, s)
    return s + 0.5 * once + c[:, None] * cross(d, once)


def exp(r):
    """The unit quaternion of one rotation vector."""
    a = np.sqrt(r @ r)
    return np.concatenate(([np.cos(0.5 * a)], r * (0.5 if a < 1e-12 else np.sin(0.5 * a) / a)))


def left_jacobian(r):
    """J of the exponential map: the angular velocity is J(r) dr/dt."""
    a = np.sqrt(r @ r)
    x = np.array([[0.0, -r[2], r[1]], [r[2], 0.0, -r[0]], [-r[1], r[0], 0.0]])
    if a < 1e-5:
        return np.eye(3) + 0.5 * x + x @ x / 6.0
    return np.eye(3) + (1.0 - np.cos(a)) / a**2 * x + (a - np.sin(a)) / a**3 * x @ x


def clamp_back(x, lo, hi):
    return min(max(x, lo), hi) - x


class Balls:
    """Muscles and stops of all ball joints: -K d + J(d)^-T K s with d = log(R R*^-1), along the zero frames."""

    def __init__(self, specs, model):
        joints = [model.joint(spec["joint"]) for spec in specs]
        n = len(joints)
        self.q = np.array([j.qposadr[0] + np.arange(4) for j in joints], dtype=int).reshape(n, 4)
        self.v = np.array([j.dofadr[0] + np.arange(3) for j in joints], dtype=int).reshape(n, 3)
        limits = [(np.reshape(s["axes"], (3, 3)), np.reshape(s["ranges"], (3, 2))) if "axes" in s else None for s in specs]
        self.limited = np.array([i for i, x in enumerate(limits) if x], dtype=int)
        self.axes = np.array([x[0] for x in limits if x]).reshape(-1, 3, 3)
        self.ranges = np.array([x[1] for x in limits if x]).reshape(-1, 3, 2)
        self.stop = np.zeros(n)
        self.k = np.zeros((n, 1))
        self.target = np.tile([1.0, 0.0, 0.0, 0.0], (n, 1))
        self.shift = np.zeros((n, 3))

    def apply(self, qpos, f):
        r = qpos[self.q]
        r = r / np.sqrt((r * r).sum(1))[:, None]
        delta = log(mul(r, conj(self.target)))
        total = self.k * (unjacobian(delta, self.shift) - delta)
        if self.limited.size:
            self.stops(r, total)
        # generalised forces of a ball are along the moving body
        f[self.v] = rotate(conj(r), total)

    def stops(self, r, total):
        """Adds the gradient of half the squared excess of swing and twist over their ranges."""
        r = r[self.limited]
        a, b, bone = self.axes[:, 0], self.axes[:, 1], self.axes[:, 2]
        along = dot(r[:, 1:], bone)
        n = np.hypot(r[:, 0], along)
        twist = np.concatenate((r[:, :1], bone * along[:, None]), 1) / np.maximum(n, 1e-300)[:, None]
        s = log(mul(r, conj(twist)))
        phi = np.stack((dot(s, a), dot(s, b), dot(log(twist), bone)), 1)
        back = np.clip(phi, self.ranges[:, :, 0], self.ranges[:, :, 1]) - phi
        for i in np.flatnonzero(back.any(1)):
            swing = a[i] * phi[i, 0] + b[i] * phi[i, 1]
            jac = left_jacobian(swing)
            bent = rotate(exp(swing)[None], bone[i : i + 1])[0]
            omega = np.column_stack((jac @ a[i], jac @ b[i], bent))
            joint = self.limited[i]
            total[joint] += self.stop[joint] * np.linalg.solve(omega.T, back[i])


def model_from_file(path):
    """A model file as MuJoCo compiles it; of a URDF only what has mass or moves."""
    if path.lower().endswith(".urdf"):
        tree = ElementTree.parse(path).getroot()
        for link in tree.iter("link"):
            # looks, collision solids and their meshes carry no mass
            for child in [c for c in link if c.tag != "inertial"]:
                link.remove(child)
        spec = mujoco.MjSpec.from_string(ElementTree.tostring(tree, encoding="unicode"))
    else:
        spec = mujoco.MjSpec.from_file(path)
    # welded bodies stay bodies, in the order of the file, and a welded base keeps its mass
    spec.compiler.fusestatic = False
    return spec.compile()


class Session:
    def __init__(self):
        self.m = self.d = None

    def load(self, request, _):
        mujoco.set_mjcb_control(None)
        if "xml" in request:
            m = mujoco.MjModel.from_xml_string(request["xml"])
        else:
            m = model_from_file(request["path"])
        flags = mujoco.mjtDisableBit
        for name in request.get("disable", []):
            m.opt.disableflags |= int(getattr(flags, "mjDSBL_" + name.upper()))
        if request.get("no_armature") and m.dof_armature.any():
            m.dof_armature[:] = 0.0
            # what the model derives of it, such as the inertia of a slide; it uses its data as scratch
            mujoco.mj_setConst(m, mujoco.MjData(m))
        m.opt.enableflags |= int(mujoco.mjtEnableBit.mjENBL_ENERGY)
        self.m, self.d = m, mujoco.MjData(m)
        kinds = ["free", "ball", "slide", "hinge"]
        joints = [
            {
                "name": m.joint(j).name,
                "kind": kinds[m.jnt_type[j]],
                "q": int(m.jnt_qposadr[j]),
                "v": int(m.jnt_dofadr[j]),
                "body": m.body(m.jnt_bodyid[j]).name,
            }
            for j in range(m.njnt)
            if "path" in request or m.body(m.jnt_bodyid[j]).name != "ground"
        ]
        bodies = [{"name": m.body(b).name, "mass": float(m.body_mass[b])} for b in range(m.nbody)]
        mujoco.mj_kinematics(m, self.d)
        mujoco.mj_comPos(m, self.d)
        places = (self.d.xipos, self.d.xanchor[: len(joints)], self.d.xaxis[: len(joints)])
        answer(
            {
                "nq": m.nq,
                "nv": m.nv,
                "joints": joints,
                "bodies": bodies,
                "gravity": m.opt.gravity.tolist(),
                "version": mujoco.__version__,
            },
            np.concatenate((m.qpos0, *(x.ravel() for x in places))),
        )

    def dynamics(self, request, numbers):
        """For each state q v a: inverse dynamics, bias, gravity, mass matrix, com, momenta, energies."""
        m, d = self.m, self.d
        width = m.nq + 2 * m.nv
        full = np.zeros((m.nv, m.nv))
        out = []
        for row in numbers.reshape(-1, width):
            d.qpos[:], d.qvel[:], d.qacc[:] = row[: m.nq], row[m.nq : m.nq + m.nv], row[m.nq + m.nv :]
            mujoco.mj_inverse(m, d)
            out += [d.qfrc_inverse.copy(), d.qfrc_bias.copy()]
            mujoco.mj_fullM(m, d, full)
            mujoco.mj_energyPos(m, d)
            mujoco.mj_energyVel(m, d)
            mujoco.mj_subtreeVel(m, d)
            mass = m.body_subtreemass[0]
            rest = np.concatenate(
                (
                    full.ravel(),
                    d.subtree_com[0],
                    mass * d.subtree_linvel[0],
                    d.subtree_angmom[0],
                    [d.energy[1], d.energy[0]],
                )
            )
            d.qvel[:] = 0.0
            mujoco.mj_fwdPosition(m, d)
            mujoco.mj_fwdVelocity(m, d)
            out += [d.qfrc_bias.copy(), rest]
        answer({}, np.concatenate(out))

    def simulate(self, request, numbers):
        """Starts a run: integrator, step, muscles, root."""
        m = self.m
        names = mujoco.mjtIntegrator
        m.opt.integrator = int(getattr(names, "mjINT_" + request["integrator"].upper()))
        m.opt.timestep = request["timestep_s"]
        m.opt.iterations, m.opt.tolerance = 200, 1e-12
        self.substeps = request["substeps"]
        for g in range(m.ngeom):
            if request.get("solref"):
                m.geom_solref[g] = request["solref"]
            if request.get("solimp"):
                m.geom_solimp[g] = request["solimp"]
        # links that touch each other yield as everything else does
        for p in range(m.npair):
            if request.get("solref"):
                m.pair_solref[p] = request["solref"]
            if request.get("solimp"):
                m.pair_solimp[p] = request["solimp"]
        self.balls = Balls(request["balls"], m)
        self.hinges = []
        for spec in request["hinges"]:
            joint = m.joint(spec["joint"])
            lo, hi = spec.get("range") or (-np.inf, np.inf)
            acts = [m.actuator(f"{spec['joint']}_{k}").id for k in ("lo", "hi", "damp")]
            self.hinges.append([joint.qposadr[0], joint.dofadr[0], lo, hi, 0.0, acts])
        self.pinned = bool(request.get("pinned"))
        if self.pinned:
            # a root that moves as told: next to this inertia what hangs on it weighs nothing
            m.dof_armature[:6] = PIN
            # the inertia of a body that carries nothing is taken from here
            m.dof_M0[:6] += PIN
        self.root_acc = np.zeros(6)
        d = self.d = mujoco.MjData(m)
        d.qpos[:], d.qvel[:] = numbers[: m.nq], numbers[m.nq :]
        self.turning = None
        if request.get("ground"):
            joint = m.joint("ground")
            self.turning = (joint.qposadr[0] + np.arange(4), joint.dofadr[0] + np.arange(3))
            d.qpos[self.turning[0]] = request["ground"]
        # what is of the world: -1 the ground, -2 and below the props
        self.world = {mujoco.mj_name2id(m, mujoco.mjtObj.mjOBJ_GEOM, "ground"): -1}
        for g in range(m.ngeom):
            name = m.geom(g).name
            if m.geom_bodyid[g] == 0 and name.startswith("prop_"):
                self.world[g] = -2 - int(name[5:])
        mujoco.mj_forward(m, d)
        mujoco.set_mjcb_control(self.control)
        answer({})

    def stops(self, request, numbers):
        n = len(self.hinges)
        for hinge, k in zip(self.hinges, numbers[:n]):
            hinge[4] = k
        self.balls.stop = numbers[n:]
        answer({})

    def masses(self, request, numbers):
        """Other masses for the same bodies. Numbers: body mass com(3) inertia(9) for each."""
        m = self.m
        for row in numbers.reshape(-1, 14):
            body = int(row[0])
            values, axes = np.linalg.eigh(row[5:].reshape(3, 3))
            if np.linalg.det(axes) < 0.0:
                axes[:, 0] *= -1.0
            m.body_mass[body], m.body_ipos[body], m.body_inertia[body] = row[1], row[2:5], values
            mujoco.mju_mat2Quat(m.body_iquat[body], np.ascontiguousarray(axes).ravel())
        # what the model derives of them; it uses its data as scratch
        mujoco.mj_setConst(m, mujoco.MjData(m))
        answer({})

    def control(self, m, d):
        f = d.qfrc_applied
        f[:] = 0.0
        for q, v, lo, hi, stop, _ in self.hinges:
            x = d.qpos[q]
            if stop > 0.0 and not lo <= x <= hi:
                f[v] = stop * clamp_back(x, lo, hi)
        self.balls.apply(d.qpos, f)
        if self.pinned:
            f[:3] = PIN * self.root_acc[:3]
            f[3:6] = PIN * rotate(conj(d.qpos[None, 3:7]), self.root_acc[None, 3:])[0]

    def step(self, request, numbers):
        """One control step. Numbers: k_lo k_hi k_d per hinge, K k_d target shift per ball, root
        acceleration (6), turn (4) and rate (3) of ground that turns, then body point force moment per wrench."""
        m, d = self.m, self.d
        at = 0
        for q, v, lo, hi, stop, acts in self.hinges:
            d.ctrl[acts] = numbers[at : at + 3]
            at += 3
        balls = self.balls
        count = len(balls.k)
        rows = numbers[at : at + 9 * count].reshape(count, 9)
        balls.k, balls.target, balls.shift = rows[:, :1], rows[:, 2:6], rows[:, 6:]
        m.dof_damping[balls.v] = rows[:, 1:2]
        at += 9 * count
        self.root_acc = numbers[at : at + 6]
        at += 6
        if self.turning:
            # heavier than all that stands on it: it keeps its rate through the step
            d.qpos[self.turning[0]] = numbers[at : at + 4]
            d.qvel[self.turning[1]] = numbers[at + 4 : at + 7]
            at += 7
        d.xfrc_applied[:] = 0.0
        for w in numbers[at:].reshape(-1, 10):
            body = int(w[0])
            d.xfrc_applied[body, :3] += w[4:7]
            d.xfrc_applied[body, 3:] += w[7:] + np.cross(w[1:4] - d.xipos[body], w[4:7])
        sums = {}
        f = np.zeros(6)
        for _ in range(self.substeps):
            mujoco.mj_step(m, d)
            for i in range(d.ncon):
                self.contact(i, f, sums)
        touching = []
        for (body, geom, against, *_), (load, at, force, depth) in sums.items():
            touching += [body, *(at / load), *(force / self.substeps), depth, against]
            if against >= 0:
                # the other link feels the opposite at the same point
                touching += [against, *(at / load), *(-force / self.substeps), depth, body]
        bad = bool(np.isnan(d.qpos).any() or d.warning[int(mujoco.mjtWarning.mjWARN_BADQACC)].number)
        answer({"bad": bad, "time_s": d.time}, np.concatenate((d.qpos, d.qvel, touching)))

    def contact(self, i, f, sums):
        """Adds one contact of one substep to the sums of its corner."""
        m, d = self.m, self.d
        c = d.contact[i]
        mujoco.mj_contactForce(m, d, i, f)
        if c.efc_address < 0 or f[0] <= 0.0:
            return
        # the frame's first row points from the first geom to the second, and so does the force
        if c.geom1 in self.world:
            sign, geom, against = 1.0, c.geom2, self.world[c.geom1]
        elif c.geom2 in self.world:
            sign, geom, against = -1.0, c.geom1, self.world[c.geom2]
        else:
            sign, geom, against = -1.0, c.geom1, int(m.geom_bodyid[c.geom2])
        force = sign * (c.frame.reshape(3, 3).T @ f[:3])
        local = d.geom_xmat[geom].reshape(3, 3).T @ (c.pos - d.geom_xpos[geom])
        key = (int(m.geom_bodyid[geom]), geom, against, *(local > 0.0).tolist())
        load, at, total, _ = sums.get(key, (0.0, np.zeros(3), np.zeros(3), 0.0))
        sums[key] = (load + f[0], at + f[0] * c.pos, total + force, -c.dist)


# kg and kg m^2
PIN = 1e9


def main():
    session = Session()
    answer({"mujoco": mujoco.__version__, "numpy": np.__version__})
    while True:
        request, numbers = receive()
        try:
            getattr(session, request["op"])(request, numbers)
        except Exception as error:  # reported to the other side, which knows what it asked for
            answer({"error": f"{type(error).__name__}: {error}"})


main()
