"""scikit-learn's FastICA and dtaidistance on the inputs that `decompose` wrote: one JSON line of CPU seconds."""

import json
import sys
import time

import numpy as np
from dtaidistance import dtw
from sklearn.decomposition import FastICA

folder = sys.argv[1]
x = np.fromfile(f"{folder}/ica.f64").reshape(2000, 93)
a, b = np.fromfile(f"{folder}/dtw_a.f64"), np.fromfile(f"{folder}/dtw_b.f64")


def least(f, times):
    best = float("inf")
    for _ in range(times):
        began = time.process_time()
        f()
        best = min(best, time.process_time() - began)
    return best


def ica(solver):
    model = FastICA(5, whiten="unit-variance", whiten_solver=solver, random_state=0, max_iter=500, tol=1e-4)
    model.fit_transform(x)
    return model.n_iter_


steps = ica("svd")
print(json.dumps(dict(
    engine="scikit-learn, dtaidistance",
    ica_s=least(lambda: ica("svd"), 10),
    ica_eigh_s=least(lambda: ica("eigh"), 10),
    steps=steps,
    dtw_s=least(lambda: dtw.warping_path_fast(a, b, include_distance=True), 10),
    distance=dtw.warping_path_fast(a, b, include_distance=True)[1],
)))
