"""The jobs of same_bytes.py: which command lines are compared.

In: names of the files under `scenes/`, and the data folder. Out: jobs, each a few command lines that are run one after another in
one folder. Groups: every scene, performance and retargeted scene of the library; words that no scene of the library says; clips;
options of `render`; every other command; bad input; the small cases of the data folder; MuJoCo (`crosscheck`).
"""

import fnmatch
from dataclasses import dataclass, field
from pathlib import Path

# Words of a scene that no scene of the library says, or not together.
WORDS = {
    "script": """Scene(
    character: "scenes/characters/human.ron",
    rate_hz: 60,
    properties: (curve: Overshoot, tension: 1.5, duration_s: 0.5, hold_s: 0.2),
    script: [Action(name: "a", cycles: [Cycle(repetitions: 2, poses: [
        Pose(set_deg: { "elbow_r": 60, "shoulder_l": (0, -30, -40) },
             elements: { "elbow_r": (curve: Bezier(0.3, 0, 0.6, 1), tension: 3) }),
        Pose(curve: Anticipate, rest: ["elbow_r", "shoulder_l"]),
    ])])],
    inserts: [Insert(name: "nod", start_s: 0.7, curve: EaseIn, duration_s: 0.3, set_deg: { "head": (15, 0, 0) })],
    edits: [
        Succession(on: "a", offset_s: 0.05, direction: Reverse),
        Amplitude(on: "a_0_0", repetition: 1, parts: ["arm_r"], factor: 1.3),
        Tension(parts: ["arm_l"], absolute: (over_time_s: [(0, 1), (1, 2)])),
    ],
    world: (gravity_m_s2: (0, -9.0, 0), ground: Plane(friction: 0.6, height_m: 0.05)),
    physics: (rate_hz: 200, substeps: 4, tension: 1.2, blend: Gains),
    balance: (without: [Hip], ankle_stiffness: 1.3, arms: true),
    pushes: [
        Push(link: "chest", at_m: (0, 0.1, 0), impulse_ns: 6, towards_deg: 40, start_s: 1.2),
        Push(link: "elbow_l", impulse_ns: (1, 0, 2), start_s: 1.5, duration_s: 0.2),
    ],
    carried: [Carried(link: "wrist_l", mass_kg: 1.5, from_s: 0.4, known: false)],
    reactive: [Gaze(at_m: (0.5, 1.2, 1.5), from_s: 0.3, to_s: 1.8, joints: ["head"])],
    root: Free,
    settle_s: 1,
)
""",
    "footwork": """Scene(
    character: "scenes/characters/human.ron",
    rate_hz: 60,
    footwork: [
        Step(limb: "leg_r", start_s: 0.5, to_m: (-0.05, 0.15), turn_deg: -15),
        Jump(start_s: 1.6, duration_s: 0.3, point_deg: 30, tuck_m: 0.05),
    ],
    script: [Action(name: "crouch", start_s: 1.1, cycles: [Cycle(poses: [
        Pose(duration_s: 0.4, set_m: { "pelvis_y": -0.1 }), Pose(duration_s: 0.3, rest: ["pelvis_y"]),
    ])])],
    root: Pinned,
    settle_s: 1,
)
""",
    "air": """Scene(
    character: "scenes/characters/human.ron",
    script: [Action(name: "a", cycles: [Cycle(poses: [
        Pose(duration_s: 0.5, set_deg: { "hip_l": (-40, 0, 0), "knee_l": 50 }),
    ])])],
    planted: ["leg_r"],
    world: (ground: None),
    root: Assisted(force_n: 900, moment_nm: 300),
    settle_s: 0.5,
)
""",
    "fidelity": """Scene(
    character: "scenes/characters/human.ron",
    script: [Action(name: "a", cycles: [Cycle(poses: [Pose(duration_s: 0.5, set_deg: { "chest": (20, 0, 0) })])])],
    root: Fidelity(0.4),
    settle_s: 0.5,
)
""",
    "motion": """Scene(
    character: "scenes/characters/penguin.ron",
    motion: Retarget(of: "shared/mocap/bvh/16_21.bvh", model: Gp, stop_after: Contact, size: Fixed(0.3), sway: false),
    world: (gravity_m_s2: (0, -5, 0), ground: Plane(friction: 0.5)),
    pushes: [Push(link: "beak", impulse_ns: (0.1, 0, 0), start_s: 0.5)],
    root: Pinned,
)
""",
    "wrong": """Scene(
    character: "scenes/characters/human.ron",
    script: [Action(name: "a", cycles: [Cycle(poses: [Pose(duration_s: 0.5, set_deg: { "elbw_r": 20 })])])],
)
""",
}


@dataclass
class Job:
    group: str
    name: str
    steps: list  # command lines, each a list of words
    quick: bool = False
    slow: bool = False
    texts: dict = field(default_factory=dict)  # files made beforehand: name to text
    cases: bool = False  # the scenes of shared/cases, as if they lay in scenes/

    @property
    def key(self):
        return f"{self.group}/{self.name}"

    @property
    def needs_shared(self):
        text = " ".join(w for s in self.steps for w in s) + " ".join(self.texts.values())
        return self.cases or "shared/" in text


def jobs(scenes, shared):
    """All jobs, given names of files under `scenes/` and the data folder (or None)."""
    made = []

    def add(group, name, *lines, **how):
        steps = [line.split() if isinstance(line, str) else line for line in lines]
        made.append(Job(group, name, steps, **how))

    def listed(pattern):
        return sorted(n for n in scenes if fnmatch.fnmatch(n, pattern) and n.count("/") == pattern.count("/"))

    def data(pattern):
        return [f"shared/{p.relative_to(shared)}" for p in sorted(shared.glob(pattern))] if shared else []

    bvh = "shared/mocap/bvh/"
    to = "--to scenes/characters/"

    for scene in listed("*.ron"):
        stem = scene[:-4]
        add("scenes", stem, f"render scenes/{scene}", quick=stem in {"bow", "crate"})
    for scene in listed("performances/*.ron"):
        stem = Path(scene).stem
        add("performances", stem, f"render scenes/{scene} --kinematic", quick=stem in {"anger", "walk"})
    for scene in listed("retargeted/*.ron"):
        add("retargeted", Path(scene).stem, f"render scenes/{scene} --kinematic --out out/kinematic",
            f"render scenes/{scene}", quick=True)
    for name, text in WORDS.items():
        add("words", name, f"render {name}.ron --no-plots", f"inspect --json {name}.ron", texts={f"{name}.ron": text},
            quick=True)

    add("clips", "pinned", f"render {bvh}16_21.bvh", quick=True)
    add("clips", "assisted", f"render {bvh}02_01.bvh --root assisted:80,50 --span 0.5..2.5")
    add("clips", "free", f"render {bvh}14_37.bvh --root free")
    add("clips", "free-in-parts", f"render {bvh}14_24.bvh --root free --span 0..14")
    add("clips", "free-part", f"render {bvh}14_24.bvh --root free --span 0..4 --no-plots", quick=True)
    add("clips", "span", f"render {bvh}135_04.bvh --root pinned --span 2.5..5 --tension 2")
    add("clips", "still", f"render {bvh}127_01.bvh --root free --no-plots")
    add("clips", "kinematic", f"render {bvh}02_03.bvh --kinematic")
    add("clips", "t-pose", "render shared/mocap/cgspeed/09_04.bvh --drop-t-pose --units 0.0564444 --up y --no-plots")
    add("clips", "fidelity", f"render {bvh}16_05.bvh --fidelity 0.5 --span 0..1.5 --json --no-plots")
    add("clips", "body", f"inspect {bvh}16_21.bvh --write-body body.ron",
        f"render {bvh}16_21.bvh --body body.ron --span 0..1 --no-plots", quick=True)
    for clip in data("bvh-zoo/*.bvh"):
        add("clips", f"zoo-{Path(clip).stem}", f"render {clip} --kinematic --no-plots")

    options = {
        "tension": "--tension 0.5", "pinned": "--root pinned", "assisted": "--root assisted",
        "budget": "--root assisted:80,50", "fidelity": "--fidelity 0.3", "no-edits": "--no-edits",
        "steps": "--rate 120 --substeps 3", "without": "--without hip,weight", "no-ankle": "--without ankle", "json": "--json",
    }
    for name, words in options.items():
        add("options", name, f"render scenes/reach.ron --no-plots {words}", quick=name in {"tension", "assisted", "steps"})
    add("options", "again", "render scenes/twitch.ron --out out/a", "render scenes/twitch.ron --kinematic --out out/a",
        "render scenes/twitch.ron --no-plots --out out/a")

    fear = "retarget scenes/performances/fear.ron"
    happy = f"retarget scenes/performances/happiness.ron {to}lamp.ron --rate 30 --stop-after map"
    walk = f"retarget {bvh}16_21.bvh --rate 30"
    for body in ("lamp", "penguin", "squirrel"):
        add("retarget", f"anger-{body}", f"retarget scenes/performances/anger.ron {to}{body}.ron --rate 30",
            quick=body == "lamp")
        add("retarget", f"walk-{body}", f"{walk} {to}{body}.ron", quick=body == "penguin")
    add("retarget", "full-rate", f"retarget scenes/performances/surprise.ron {to}squirrel.ron --no-plots")
    add("retarget", "legs", f"retarget {bvh}02_03.bvh --rate 30 {to}squirrel.ron --refine legs --no-plots", quick=True)
    add("retarget", "refine", f"{walk} {to}penguin.ron --refine root --size-ratio paper --out out/a --no-plots",
        f"{walk} {to}squirrel.ron --refine chest,spine --size-ratio 0.2 --no-sway --out out/b --no-plots")
    add("retarget", "stages", *(
        f"retarget scenes/performances/surprise.ron {to}squirrel.ron --rate 30 --stop-after {s} --out out/{s}"
        for s in ("map", "global")))
    add("retarget", "models", *(
        f"retarget scenes/performances/dance.ron {to}penguin.ron --rate 30 --model {m} --no-plots --out out/{m}"
        for m in ("gp", "pca", "nn3", "nn10")))
    add("retarget", "contacts", f"{walk} {to}penguin.ron --no-plots --out out/a",
        f"{walk} {to}penguin.ron --contacts out/a/contacts.ron --no-plots --out out/b")
    add("retarget", "performed", f"{walk} {to}penguin.ron --no-plots --out out/a",
        "render out/a/retargeted.bvh --body scenes/characters/penguin.ron --units 0.01 --up y --no-plots --out out/b",
        "render out/a/human.bvh --units 0.01 --up y --no-plots --out out/c")
    add("retarget", "guess", f"{fear} {to}lamp.ron --guess 1.5,7", f"{walk} {to}squirrel.ron --guess 0.5", quick=True)
    add("retarget", "sheet", *(f"{fear} {to}{b}.ron --sheet --out out/{b}" for b in ("lamp", "penguin", "squirrel")))
    add("retarget", "contact", f"retarget scenes/performances/surprise.ron {to}squirrel.ron --rate 30 --stop-after contact",
        quick=True)
    add("retarget", "suggest", f"{walk} {to}penguin.ron --suggest-keyposes 3 --no-plots --json")
    add("retarget", "compare", f"{happy} --compare --no-plots")
    add("retarget", "study", f"{happy} --study --no-plots")

    add("push", "stand", "push scenes/stand.ron --directions 4 --tolerance 5")
    add("push", "one", "push scenes/stand.ron --directions 1 --tolerance 20", quick=True)
    add("push", "options", "push scenes/stand.ron --directions 2 --tolerance 20 --tension 2 --no-plots --out out/a",
        "push scenes/stand.ron --directions 1 --tolerance 20 --without hip,weight --no-plots --json --out out/b")
    add("tune", "stand", "tune scenes/stand.ron --evaluations 20 --slices 0 --directions 0",
        "render scenes/stand.ron --patch out/stand-tune/patch.ron --no-plots",
        "push scenes/stand.ron --patch out/stand-tune/patch.ron --directions 1 --tolerance 20 --no-plots")
    few = "tune scenes/stand.ron --parameters shift,tension"
    add("tune", "few", f"{few} --solver nelder-mead --evaluations 3 --slices 2 --directions 0")
    add("tune", "random", f"{few} --start random --seed 7 --evaluations 2 --slices 0 --directions 0", quick=True)
    sweep = "tune scenes/stand.ron --sweep shift=0..1.2:2 --sweep tension=0.5..2:2"
    add("tune", "sweep", f"{sweep} --shard 1/2 --out out/a", f"{sweep} --shard 2/2 --out out/b",
        "tune scenes/stand.ron --merge out/a/sweep.csv out/b/sweep.csv --out out/all")
    add("tune", "list", "tune --list", quick=True)
    add("pareto", "twitch", "render scenes/twitch.ron --pareto 0.1,0.5")
    add("pareto", "clip", f"render {bvh}127_01.bvh --pareto 0,0.3 --json", quick=True)

    add("analyze", "clip", f"analyze {bvh}16_21.bvh --format csv,mot,npz", quick=True)
    add("analyze", "scene", "analyze scenes/reach.ron --format csv,mot,npz")
    add("analyze", "run", "render scenes/crate.ron --no-plots", "analyze out/crate --out out/a",
        "analyze out/crate/trace.npz --out out/b --no-plots --json")
    add("analyze", "options", f"analyze {bvh}02_03.bvh --smooth 6 --friction 0.6 --sink-mm 3 --no-plots --out out/a",
        f"analyze {bvh}02_03.bvh --smooth off --format csv --no-plots --out out/b")
    add("plot", "run", "render scenes/bow.ron --no-plots", "plot out/bow")
    add("plot", "clip", f"plot {bvh}16_21.bvh --what all")
    add("plot", "scene", "plot scenes/seesaw.ron --json")
    add("plot", "some", "render scenes/reach.ron --no-plots",
        "plot out/reach/trace.npz --what torque --joints knee_l,knee_r --out knees.svg",
        "plot out/reach --what contact --feet leg_l --from-s 0.5 --to-s 1.5 --out contact.png",
        quick=True)

    clips = [f"{bvh}{c}.bvh" for c in ("16_21", "14_24", "03_01")]
    characters = [f"scenes/{c}" for c in listed("characters/*.ron")]
    add("inspect", "json", "inspect --json scenes/bow.ron", "inspect --json scenes/characters/human.ron",
        f"inspect --json {clips[0]}", quick=True)
    add("inspect", "scenes", *(f"inspect{j} scenes/{s}" for s in
        listed("*.ron") + listed("performances/*.ron") + listed("retargeted/*.ron") for j in ("", " --json")))
    add("inspect", "characters", *(f"inspect{j} {c}" for c in characters for j in ("", " --json")), quick=True)
    add("inspect", "clips", *(f"inspect{j} {c}" for c in clips for j in ("", " --json")))
    add("inspect", "zoo", *(["inspect", "--json", c] for c in
        data("bvh-zoo/*.bvh") + data("bvh-zoo/synthetic/*.bvh") + data("cases/clips/*.bvh")))
    add("convert", "scene", "convert scenes/bow.ron bow.bvh", "convert scenes/bow.ron bow.glb",
        "convert scenes/bow.ron bow-30.bvh --rate 30 --out-units 1", quick=True)
    add("convert", "body", "convert scenes/characters/human.ron human.xml", f"convert {clips[0]} clip.xml", quick=True)
    add("convert", "clip", f"convert {clips[0]} a.glb", f"convert {clips[0]} b.bvh --rate 30 --out-units 0.01",
        "convert shared/mocap/cgspeed/09_04.bvh c.bvh --drop-t-pose --up z")
    add("convert", "characters", *(f"convert {c} {Path(c).stem}.xml" for c in characters))
    add("convert", "zoo", *(["convert", c, f"{Path(c).stem}.bvh"] for c in data("bvh-zoo/*.bvh")),
        *(["convert", c, f"synthetic-{Path(c).stem}.glb"] for c in data("bvh-zoo/synthetic/*.bvh")))
    models = data("models/*/*.xml") + data("models/*/*.urdf") + data("cases/models/*")
    add("convert", "models", *(["convert", m, f"{Path(m).name}.xml", "--dynamics-only"] for m in models))

    add("errors", "words", "render scenes/none.ron", "render", f"render {clips[0]} --no-edits",
        "render scenes/bow.ron --span 0..1", "render scenes/bow.ron --units 1", f"render {clips[0]} --root held",
        "render scenes/bow.ron --patch none.ron", "render scenes/characters/human.ron", "inspect none.bvh",
        "convert scenes/bow.ron bow.fbx", "convert scenes/bow.ron bow.xml --rate 3", f"push {clips[0]}",
        "tune scenes/bow.ron --parameters shift,none", f"{fear} {to}none.ron", f"{fear} {to}human.ron",
        "plot scenes/bow.ron --what gains", "analyze none", "render wrong.ron --out out/wrong/deep",
        quick=True, texts={"wrong.ron": WORDS["wrong"]})

    # three cases overflow the stack: they refer to themselves
    for scene in data("cases/scenes/*.ron"):
        name = Path(scene).stem
        if name not in {"a2", "b2", "selfm"}:
            add("cases", name, f"render cases/{name}.ron --no-plots", cases=True)
    for clip in data("cases/clips/*.bvh"):
        add("cases", f"clip-{Path(clip).stem}", f"render {clip} --no-plots", f"analyze {clip} --no-plots")

    add("crosscheck", "lamp", "crosscheck scenes/characters/lamp.ron --states 20", quick=True)
    add("crosscheck", "model", "crosscheck shared/models/dm_control/walker.xml --dynamics-only --states 20")
    add("crosscheck", "fault", "crosscheck scenes/characters/human.ron --states 20 --states-only --inject mass:chest*1.01")
    add("crosscheck", "push", "push scenes/stand.ron --engine mujoco --directions 1 --tolerance 20 --no-plots",
        slow=True)
    add("crosscheck", "bow", "crosscheck scenes/bow.ron --states 50", slow=True)
    return [job for job in made if job.steps]
