"""Makes the numbers of tests/gp_by_sklearn.rs: GP regression by scikit-learn on the same data.

    python3 -m venv venv && venv/bin/pip install scikit-learn==1.9.1 && venv/bin/python learn/tests/gp_by_sklearn.py

Inputs and outputs are centred and divided by the root of their mean variance, as `learn` does; the kernel is
theta1 exp(-theta2/2 r^2) + theta3 + noise. 20 restarts; the best optimum is what is printed.
"""

import numpy as np
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import RBF, ConstantKernel, WhiteKernel


def data(first, count):
    i = np.arange(first, first + count, dtype=float)
    y = np.stack([np.sin(0.7 * i), np.cos(1.3 * i + 0.2), np.sin(0.31 * i * i)], 1)
    z = np.stack([np.sin(2 * y[:, 0]) + y[:, 1] * y[:, 2], np.exp(-y[:, 1]) + 0.5 * y[:, 0]], 1)
    ripple = 0.03 * np.stack([np.sin(37.7 * i * i), np.cos(91.3 * i * i)], 1)
    return y, z + ripple


y, z = data(0, 40)
probe, _ = data(100, 3)
my, sy = y.mean(0), np.sqrt(y.var(0).mean())
mz, sz = z.mean(0), np.sqrt(z.var(0).mean())
kernel = ConstantKernel(1, (1e-7, 1e4)) * RBF(1, (1e-3, 1e5)) + ConstantKernel(0.01, (1e-9, 1e4)) + WhiteKernel(0.01, (1e-6, 1e2))
gp = GaussianProcessRegressor(kernel, n_restarts_optimizer=20, random_state=0, alpha=0)
gp.fit((y - my) / sy, (z - mz) / sz)
mean, std = gp.predict((probe - my) / sy, return_std=True)
print("kernel", gp.kernel_)
print("lml", repr(gp.log_marginal_likelihood_value_))
print("mean", (mz + sz * mean).tolist())
print("variance", ((sz * std[:, 0]) ** 2).tolist())
