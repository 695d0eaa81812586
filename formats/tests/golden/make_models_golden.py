#!/usr/bin/env python3
"""Writes models.json: what MuJoCo makes of ../models, and its inverse dynamics and mass matrix in random states.

    python make_models_golden.py > models.json

Contacts, limits, equalities, friction, springs, damping and actuators are off, armature is 0. Free and ball joints
are in MuJoCo's conventions (angular velocity along the body's axes). Seed 3; versions are written into the file.
"""

import json
import pathlib
import sys

import mujoco
import numpy as np

FOLDER = pathlib.Path(__file__).resolve().parent.parent / "models"
STATES = 4


def state(model, data, rng):
    data.qpos[:] = rng.uniform(-1.2, 1.2, model.nq)
    mujoco.mj_normalizeQuat(model, data.qpos)
    data.qvel[:] = rng.uniform(-5, 5, model.nv)
    data.qacc[:] = rng.uniform(-50, 50, model.nv)
    mujoco.mj_inverse(model, data)
    mass = np.zeros((model.nv, model.nv))
    for k in range(model.nv):  # columns: differences of inverse dynamics at unit accelerations
        other = mujoco.MjData(model)
        other.qpos[:] = data.qpos
        other.qacc[k] = 1
        mujoco.mj_inverse(model, other)
        mass[:, k] = other.qfrc_inverse
        other.qacc[k] = 0
        mujoco.mj_inverse(model, other)
        mass[:, k] -= other.qfrc_inverse
    return {
        "qpos": data.qpos.tolist(),
        "qvel": data.qvel.tolist(),
        "qacc": data.qacc.tolist(),
        "tau": data.qfrc_inverse.tolist(),
        "mass_matrix": mass.tolist(),
        "com": data.subtree_com[0].tolist(),
    }


def entry(path):
    model = mujoco.MjModel.from_xml_path(str(path))
    off = mujoco.mjtDisableBit
    model.opt.disableflags = int(
        off.mjDSBL_CONSTRAINT | off.mjDSBL_SPRING | off.mjDSBL_DAMPER | off.mjDSBL_ACTUATION
    )
    model.dof_armature[:] = 0
    data = mujoco.MjData(model)
    rng = np.random.default_rng(3)
    bodies = [
        {
            "name": model.body(i).name,
            "parent": int(model.body_parentid[i]),
            "mass": float(model.body_mass[i]),
            "ipos": model.body_ipos[i].tolist(),
            "iquat_wxyz": model.body_iquat[i].tolist(),
            "inertia_diag": model.body_inertia[i].tolist(),
        }
        for i in range(model.nbody)
    ]
    joints = [
        {
            "name": model.joint(i).name,
            "body": int(model.jnt_bodyid[i]),
            "pos": model.jnt_pos[i].tolist(),
            "limited": bool(model.jnt_limited[i]),
            "range": model.jnt_range[i].tolist(),
        }
        for i in range(model.njnt)
    ]
    return {
        "gravity": model.opt.gravity.tolist(),
        "qpos0": model.qpos0.tolist(),
        "bodies": bodies,
        "joints": joints,
        "states": [state(model, data, rng) for _ in range(STATES)],
    }


paths = sorted(p for p in FOLDER.iterdir() if p.suffix in (".xml", ".urdf"))
json.dump(
    {
        "generator": f"make_models_golden.py, mujoco {mujoco.__version__}, numpy {np.__version__}, seed 3",
        "models": {p.name: entry(p) for p in paths},
    },
    sys.stdout,
    indent=None,
    separators=(",", ":"),
)
print()
