"""A pinned beam of 20 lumps against the closed form of the lumped chain."""

import numpy as np


def test_five_lowest_frequencies(load):
    eigenvalues = load("pinned_beam", "modes").eigenvalues()
    frequencies = np.sort(eigenvalues.imag[eigenvalues.imag > 0]) / (2 * np.pi)
    assert len(frequencies) == 19
    printed = [19.01, 75.57, 168.29, 294.89, 452.25]
    np.testing.assert_allclose(frequencies[:5], printed, atol=5e-3)

    h, section = 0.6 / 20, 0.05 * 0.003
    wave = np.sqrt(68.94e9 * 0.05 * 0.003**3 / 12 / (2712.8 * section)) / h**2
    closed = wave * (2 - 2 * np.cos(np.arange(1, 20) * np.pi / 20)) / (2 * np.pi)
    np.testing.assert_allclose(frequencies, closed, rtol=1e-9)
    assert np.abs(eigenvalues.real).max() < 1e-6 * frequencies[0]
