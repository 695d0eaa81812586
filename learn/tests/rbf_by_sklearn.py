"""Makes the numbers of src/rbf/sklearn_tests.rs: the same regression by scikit-learn on the same data.

    python3 -m venv venv && venv/bin/pip install scikit-learn==1.9.1 && venv/bin/python learn/tests/rbf_by_sklearn.py

Likelihood, its gradient by the logarithms of (signal variance, length, noise variance), means and variances at a given kernel, and the
fitted kernel: of 45 examples as they are, and with their mirror images appended.
"""

import numpy as np
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import RBF, ConstantKernel, WhiteKernel


def inputs(first, count):
    i = np.arange(first, first + count, dtype=float)[:, None]
    return np.sin(0.7 * i + 1.9 * np.arange(5)[None] + 0.013 * i * i)


def targets(x, first):
    i = np.arange(first, first + len(x), dtype=float)[:, None]
    clean = np.stack([np.sin(2 * x[:, 0]) + x[:, 1] * x[:, 2], 0.5 * x[:, 3] - x[:, 0], np.cos(x[:, 4] + x[:, 1])], 1)
    return clean + 0.03 * np.sin(37.7 * i * i + np.arange(3)[None])


def mirror_input(x):
    return np.stack([x[:, 1], x[:, 0], -x[:, 2], -x[:, 4], -x[:, 3]], 1)


def mirror_target(y):
    return np.stack([-y[:, 0], y[:, 2], y[:, 1]], 1)


def show(name, x, y, probe):
    fixed = ConstantKernel(0.8) * RBF(1.3) + WhiteKernel(0.01)
    gp = GaussianProcessRegressor(fixed, optimizer=None, alpha=0).fit(x, y)
    lml, gradient = gp.log_marginal_likelihood(fixed.theta, eval_gradient=True)
    mean, std = gp.predict(probe, return_std=True)
    print(f"// {name}")
    print("likelihood:", repr(float(lml)), "gradient:", gradient.tolist())
    print("mean:", mean.tolist())
    print("variance:", (std[:, 0] ** 2).tolist())
    bounds = (1e-8, 1e5)
    free = ConstantKernel(0.8, bounds) * RBF(1.3, bounds) + WhiteKernel(0.01, bounds)
    gp = GaussianProcessRegressor(free, alpha=0, n_restarts_optimizer=5, random_state=0).fit(x, y)
    print("fitted:", np.exp(gp.kernel_.theta).tolist(), "likelihood:", repr(float(gp.log_marginal_likelihood_value_)))


x = inputs(0, 45)
y = targets(x, 0)
probe = inputs(100, 3)
show("as they are", x, y, probe)
show("with images", np.vstack([x, mirror_input(x)]), np.vstack([y, mirror_target(y)]), probe)
