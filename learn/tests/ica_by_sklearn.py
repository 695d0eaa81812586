"""Makes the numbers of tests/ica_by_sklearn.rs: FastICA by scikit-learn on the same data.

    python3 -m venv venv && venv/bin/pip install scikit-learn==1.9.1 && venv/bin/python learn/tests/ica_by_sklearn.py

The whitened data (eigenvectors of the covariance, largest entry positive), the start and the nonlinearity are the
same; printed are the rows of the rotation for both methods and three nonlinearities.
"""

import numpy as np
from sklearn.decomposition import FastICA

FRAMES, CHANNELS, K = 700, 7, 4
i = np.arange(FRAMES, dtype=float)[:, None]
t = i / 60.0
sources = np.hstack([
    2.0 * np.mod(0.83 * t, 1.0) - 1.0,
    np.sin(1.9 * t) ** 9,
    np.sin(2.9 * t + 0.4) + 0.3 * np.sin(8.1 * t),
    np.mod(0.31 * t * t, 1.0) ** 3,
])
c = np.arange(CHANNELS, dtype=float)
mix = np.stack([np.sin(1.0 + k + 1.7 * c * (k + 1)) for k in range(4)])
x = sources @ mix + c

x = x - x.mean(0)
values, vectors = np.linalg.eigh(x.T @ x / FRAMES)
order = np.argsort(-values)[:K]
vectors = vectors[:, order] * np.sign(vectors[np.abs(vectors[:, order]).argmax(0), order])
z = x @ vectors / np.sqrt(values[order])
r = np.arange(K, dtype=float)
start = np.cos(1.3 * np.outer(r, r) + r[:, None] + 0.5 * r[None, :] ** 2)

for algorithm in ("parallel", "deflation"):
    for fun in ("logcosh", "cube", "exp"):
        model = FastICA(algorithm=algorithm, fun=fun, whiten=False, w_init=start, max_iter=1000, tol=1e-12).fit(z)
        rows = ",\n            ".join("[" + ", ".join(repr(float(v)) for v in row) + "]" for row in model.components_)
        print(f"        // {algorithm}, {fun}: {model.n_iter_} steps\n        [\n            {rows},\n        ],")
