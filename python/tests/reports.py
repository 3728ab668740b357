"""Models of reports, which tests and benchmarks share."""

from __future__ import annotations

from typing import Any


def fine_model() -> dict[str, Any]:
    """A plate of 64 × 64 elements that swings in 200 states; it is linear, so that one factorisation serves all steps."""
    return {
        "title": "Fine plate",
        "analysis": {"type": "transient", "linear": True, "end_time": 1.99, "time_step": 0.01},
        "mesh": {"type": "plate", "size": [1.0, 1.0], "grid": {"elements": [64, 64]}},
        "materials": {"rubber": {"type": "isotropic", "young": 2e7, "poisson": 0.3, "density": 500.0}},
        "sections": [{"material": "rubber", "thickness": 0.02}],
        "conditions": [{"type": "clamp", "on": "u_min"}],
        "loads": [{"type": "gravity", "value": [0.0, 0.0, -1.0]}],
        "output": {
            "points": [{"name": "tip", "on": "u_max_v_max"}],
            "fields": ["displacement", "von-mises", "membrane", "bending", "surface-stress"],
            "every": 1,
            "pictures": False,
        },
    }
