#!/usr/bin/env python3
"""Are the components of a .style file those of scikit-learn's FastICA?

From the same whitened data (`activations @ rotation`), the same start (`start`), method and nonlinearity (words.ron),
scikit-learn's components are compared with the file's, up to order and sign; the least |correlation| is printed.

    python3 -m venv venv && venv/bin/pip install scikit-learn==1.9.1
    contrapposto style decompose 16_16.bvh 17_03.bvh --out out
    venv/bin/python tests/style_by_sklearn.py out/16_16-17_03.style

Shares no code with what wrote the file. Exit code: 0 at 0.999 or more, 1 below, 2 for files that cannot be judged.
"""

import re
import sys
import warnings

import numpy as np
from sklearn.decomposition import FastICA

LEAST = 0.999


def main(path):
    try:
        with np.load(path) as file:
            u, rotation, start = file["activations"], file["rotation"], file["start"]
            words = bytes(file["words.ron"]).decode()
    except (OSError, KeyError, ValueError) as error:
        print(f"{path}: {error}", file=sys.stderr)
        return 2
    said = dict(re.findall(r'(method|contrast): "(\w+)"', words))
    method = {"symmetric": "parallel", "deflation": "deflation"}[said["method"]]
    contrast = {"tanh": "logcosh", "cube": "cube", "exp": "exp"}[said["contrast"]]
    z = u @ rotation
    off = np.abs(z.T @ z / len(z) - np.eye(z.shape[1])).max()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        model = FastICA(algorithm=method, fun=contrast, whiten=False, w_init=start, max_iter=2000, tol=1e-9)
        theirs = model.fit_transform(z)
    k = u.shape[1]
    correlation = np.abs(np.corrcoef(u.T, theirs.T)[:k, k:])
    best = correlation.max(axis=1)
    print(f"{path}: {len(u)} frames, {k} components, {method}, {contrast}; covariance off 1 by {off:.1e}; {model.n_iter_} steps; "
          f"|correlation| {', '.join(f'{x:.6f}' for x in best)}")
    return 0 if best.min() >= LEAST and len(set(correlation.argmax(axis=1))) == k else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]) if len(sys.argv) == 2 else 2)
