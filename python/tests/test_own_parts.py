"""Loads and materials that are functions of Python, against beam theory, damped oscillators and closed forms of rubber."""

import functools
import tempfile
import threading
import traceback
import unittest
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from test_package import INERTIA, LENGTH, LOAD, SWING, THICKNESS, WIDTH, YOUNG, cantilever

import tegula

Array = NDArray[np.float64]

BEAM = 3.0 * YOUNG * INERTIA / LENGTH**3
# As stiff as the beam; shared by the nodes of the end.
SPRING = BEAM


def springs(time: float, positions: Array) -> Array:
    return np.outer(positions[:, 2], [0.0, 0.0, -SPRING / len(positions)])


def stiffness(time: float, positions: Array) -> Array:
    out = np.zeros((len(positions), 3, 3))
    out[:, 2, 2] = SPRING / len(positions)
    return out


class Mistake(Exception):
    pass


def tip(result: tegula.Result) -> float:
    return float(result.history["tip.uz"][-1])


class Loads(unittest.TestCase):
    def test_springs_under_the_end_of_a_cantilever_carry_their_share(self) -> None:
        exact = LOAD * WIDTH / (BEAM + SPRING)
        model = tegula.Model(cantilever())
        by_differences = model.run(loads=[tegula.NodalForce("u_max", springs)])
        by_function = model.run(loads=[tegula.NodalForce("u_max", springs, stiffness=stiffness, name="bed")])
        self.assertLess(abs(tip(by_differences) / exact - 1.0), 2e-3)
        self.assertLess(abs(tip(by_function) / tip(by_differences) - 1.0), 1e-9)
        # Newton's method has the stiffness of the springs in its tangent: an iteration more than without them at most.
        without = model.run()
        for result in (by_differences, by_function):
            self.assertLessEqual(result.summary["iterations"], without.summary["iterations"] + 1)
        # The springs take the part of the load that the support does not take.
        taken = by_function.history["load.bed.fz"][-1]
        self.assertLess(abs(taken / (-SPRING * exact) - 1.0), 2e-3)
        self.assertIn("load.python.u_max.fz", list(by_differences.history))

    def test_a_force_in_time_acts_as_the_same_formula(self) -> None:
        keys = cantilever(analysis=SWING, loads=[])
        at_tip = {"type": "force", "on": "u_max_v_min", "value": [0.0, 0.0, 1e3], "amplitude": "ramp"}
        ramp = {"ramp": {"type": "expression", "expression": "sin(40*t)"}}
        formula = tegula.Model({**keys, "loads": [at_tip], "amplitudes": ramp}).run()
        load = tegula.NodalForce("u_max_v_min", lambda time: [[0.0, 0.0, 1e3 * np.sin(40.0 * time)]])
        function = tegula.Model(keys).run(loads=[load])
        self.assertGreater(abs(tip(formula)), 1e-4)
        self.assertLess(abs(tip(function) / tip(formula) - 1.0), 1e-9)

    def oscillator(self, scheme: dict[str, Any], steps: float, **arguments: Any) -> tuple[float, float]:
        """Place of a mass on a spring with a damper after one second, and the exact one."""
        mass, omega, damping = 2.0, 2.0 * np.pi, 0.1
        decay = damping * omega
        start, rate = 0.3, np.sqrt(omega**2 - decay**2)

        def force(time: float, positions: Array, velocities: Array) -> Array:
            return -mass * (omega**2 * positions + 2.0 * decay * velocities)

        keys = {
            "analysis": {"type": "transient", "end_time": 1.0, "time_step": steps, "scheme": scheme},
            "mesh": {"type": "none"},
            "bodies": [{"name": "mass", "at": [start, 0.0, 0.0], "mass": mass}],
        }
        simulation = tegula.Model(keys).simulation(loads=[tegula.NodalForce("mass", force, **arguments)])
        while not simulation.finished:
            simulation.advance()
        place = float(simulation.values()["body.mass.x"])
        self.assertLess(abs(simulation.time - 1.0), 1e-12)
        return place, start * float(np.exp(-decay) * (np.cos(rate) + decay / rate * np.sin(rate)))

    def test_a_damped_oscillator_decays_by_its_law(self) -> None:
        schemes = [{"type": name} for name in ("energy-momentum", "generalized-alpha", "hht", "bdf2")]
        for scheme in schemes:
            with self.subTest(scheme["type"]):
                errors = []
                for step in (1e-2, 5e-3):
                    place, exact = self.oscillator(scheme, step)
                    errors.append(abs(place - exact) / 0.3)
                # Of second order, with the error (ωΔt)²/12 of the phase 2π for the trapezoidal rule: 2e-3 of the amplitude.
                self.assertLess(errors[0], 5e-3)
                self.assertLess(errors[1], 0.3 * errors[0])

    def test_stiffness_and_damping_of_functions_are_those_of_differences(self) -> None:
        mass, omega = 2.0, 2.0 * np.pi
        blocks = {
            "stiffness": lambda time, positions, velocities: [mass * omega**2 * np.eye(3)],
            "damping": lambda time, positions, velocities: [2.0 * mass * 0.1 * omega * np.eye(3)],
        }
        place, _ = self.oscillator({"type": "energy-momentum"}, 1e-2)
        with_blocks, _ = self.oscillator({"type": "energy-momentum"}, 1e-2, **blocks)
        self.assertLess(abs(place / with_blocks - 1.0), 1e-9)

    def test_drag_slows_a_free_plate_down(self) -> None:
        for scheme in ("explicit", "newmark", "energy-momentum"):
            with self.subTest(scheme):
                self.drag(scheme)

    def drag(self, scheme: str) -> None:
        analysis = {"type": "transient", "end_time": 2e-3, "scheme": {"type": scheme}}
        keys = cantilever(analysis=analysis, loads=[])
        keys["initial_velocities"] = [{"on": "all", "velocity": [0.0, 0.0, 1.0]}]
        keys["conditions"] = []
        # Drag of the mass of each node: the velocity of all nodes decays as exp(−t/τ).
        area = WIDTH * LENGTH / 40.0
        mass, tau = 7850.0 * THICKNESS * area, 5e-3

        def drag(time: float, positions: Array, velocities: Array) -> Array:
            inner = (np.abs(positions[:, 0] - 0.5 * LENGTH) < 0.49 * LENGTH, np.abs(positions[:, 1] - 0.5 * WIDTH) < 0.49 * WIDTH)
            shares = (0.5 + 0.5 * inner[0]) * (0.5 + 0.5 * inner[1])
            return -(mass / tau) * shares[:, None] * velocities

        simulation = tegula.Model(keys).simulation(loads=[tegula.NodalForce("all", drag)])
        while not simulation.finished:
            simulation.advance()
        velocities = simulation.velocities[:, 2]
        self.assertLess(np.abs(velocities / np.exp(-simulation.time / tau) - 1.0).max(), 5e-3)

    def test_tangents_hold_the_unsymmetric_stiffness(self) -> None:
        try:
            import scipy.sparse  # type: ignore[import-not-found, import-untyped, unused-ignore]
        except ImportError as missing:
            self.skipTest(str(missing))
        self.assertTrue(scipy.sparse)

        def whirl(time: float, positions: Array) -> Array:
            x, y, z = positions.T
            return 1e3 * np.column_stack([x * y - z, 2.0 * z * z, x**2 - 3.0 * y])

        equations = tegula.Model(cantilever()).equations(loads=[tegula.NodalForce("u_max", whirl)])
        bare = tegula.Model(cantilever()).equations()
        state = equations.state(time=1.0)
        added = (equations.tangent(state) - bare.tangent(bare.state(time=1.0))).toarray()
        forces = equations.residual(state) - bare.residual(bare.state(time=1.0))
        positions = equations.reference
        for node in equations.nodes[np.flatnonzero(equations.numbers[:, 0] >= 0)]:
            at = np.flatnonzero((equations.nodes == node) & (np.array(equations.kinds) == "position"))[0]
            rows = equations.numbers[at]
            x, y, z = positions[at]
            block = np.zeros((3, 3))
            force = np.zeros(3)
            if x > LENGTH - 1e-9:
                block = -1e3 * np.array([[y, x, -1.0], [0.0, 0.0, 4.0 * z], [2.0 * x, -3.0, 0.0]])
                force = whirl(1.0, positions[[at]])[0]
            scale = 1e3 * LENGTH
            self.assertLess(np.abs(added[np.ix_(rows, rows)] - block).max() / scale, 1e-6)
            self.assertLess(np.abs(forces[rows] - force).max() / scale, 1e-12)

    def test_one_call_evaluates_all_nodes(self) -> None:
        sizes = []

        def count(time: float, positions: Array) -> Array:
            sizes.append(positions.shape)
            return np.zeros_like(positions)

        tegula.Model(cantilever()).run(loads=[tegula.NodalForce("all", count)])
        self.assertEqual(set(sizes), {(63, 3)})
        # A few for each iteration: the force, three differences for a tangent, work and reactions of the step.
        self.assertLess(len(sizes), 60)

    def test_steps_keep_the_loads(self) -> None:
        loads = cantilever()["loads"]
        steps = [
            {"name": "rest", "analysis": {"type": "static"}, "loads": []},
            {"name": "load", "analysis": {"type": "static"}, "loads": loads},
        ]
        keys = cantilever(loads=[], steps=steps)
        del keys["analysis"]
        result = tegula.Model(keys).run(loads=[tegula.NodalForce("u_max", springs)])
        exact = LOAD * WIDTH / (BEAM + SPRING)
        self.assertLess(abs(tip(result.analyses["load"]) / exact - 1.0), 2e-3)

    def test_modes_have_the_stiffness_of_springs(self) -> None:
        steps = [
            {"name": "rest", "analysis": {"type": "static"}},
            {"name": "modes", "analysis": {"type": "modal", "modes": 1}},
        ]
        keys = cantilever(loads=[], steps=steps)
        del keys["analysis"]
        result = tegula.Model(keys).run(loads=[tegula.NodalForce("u_max", springs)])

        # Cantilever with the spring κ E I/L³, κ = 3, at its end: 1 + cos β cosh β + κ/β³ (sin β cosh β − cos β sinh β) = 0 (R. D. Blevins,
        # Formulas for Natural Frequency and Mode Shape).
        def equation(b: float) -> float:
            bending = float(np.sin(b) * np.cosh(b) - np.cos(b) * np.sinh(b))
            return 1.0 + float(np.cos(b) * np.cosh(b)) + 3.0 / b**3 * bending

        low, high = 1.5, 3.0
        for _ in range(60):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if equation(low) * equation(middle) > 0.0 else (low, middle)
        omega = low**2 / LENGTH**2 * float(np.sqrt(YOUNG * INERTIA / (7850.0 * WIDTH * THICKNESS)))
        self.assertLess(abs(2.0 * np.pi * result.analyses["modes"].frequencies[0] / omega - 1.0), 1e-3)


class Failures(unittest.TestCase):
    def test_an_exception_of_a_load_ends_the_run_as_it_is(self) -> None:
        mistake = Mistake("no wind today")

        def wind(time: float, positions: Array) -> Array:
            if time > 0.01:
                raise mistake
            return np.zeros_like(positions)

        model = tegula.Model(cantilever(analysis=SWING))
        load = tegula.NodalForce("u_max", wind)
        try:
            model.run(loads=[load])
        except Mistake as found:
            self.assertIs(found, mistake)
            self.assertIn("wind", [frame.name for frame in traceback.extract_tb(found.__traceback__)])
        else:
            self.fail("the run has not ended")
        simulation = model.simulation(loads=[load])
        with self.assertRaises(Mistake):
            simulation.advance(50)
        # The state is that before the step, and the simulation goes on.
        self.assertLess(simulation.time, 0.0101)
        before = simulation.time
        mistake = Mistake("still none")
        with self.assertRaises(Mistake) as caught:
            simulation.advance()
        self.assertIs(caught.exception, mistake)
        self.assertEqual(simulation.time, before)

    def test_a_run_that_an_exception_ends_is_resumed(self) -> None:
        broken = True

        def wind(time: float, positions: Array, velocities: Array) -> Array:
            if broken and time > 0.03:
                raise Mistake
            return -100.0 * velocities

        model = tegula.Model(cantilever(analysis=SWING))
        load = tegula.NodalForce("u_max", wind)
        with tempfile.TemporaryDirectory() as folder:
            with self.assertRaises(Mistake):
                model.run(Path(folder) / "part", loads=[load])
            broken = False
            resumed = model.run(Path(folder) / "part", resume=True, loads=[load])
            whole = model.run(Path(folder) / "whole", loads=[load])
            self.assertEqual(list(resumed.history["tip.uz"]), list(whole.history["tip.uz"]))
            # A run without the load is another model.
            with self.assertRaises(tegula.OutputError):
                model.run(Path(folder) / "whole", resume=True)

    def test_wrong_values_name_the_load(self) -> None:
        model = tegula.Model(cantilever())
        wrong = [
            (lambda time, positions: np.zeros((2, 3)), r'forces of the load "wind".*\(2, 3\).*\(3, 3\) is expected'),
            (lambda time, positions: np.full((3, 3), np.nan), r'forces of the load "wind".*row 0 has the value NaN'),
            (lambda time, positions: "calm", r'forces of the load "wind".*str is given'),
            (lambda time, positions: None, r'forces of the load "wind"'),
        ]
        for function, message in wrong:
            for begin in (lambda load: model.run(loads=[load]), lambda load: model.simulation(loads=[load]).advance()):
                with self.subTest(message), self.assertRaisesRegex(ValueError, message):
                    begin(tegula.NodalForce("u_max", function, name="wind"))
        equations = model.equations(loads=[tegula.NodalForce("u_max", wrong[0][0], name="wind")])
        with self.assertRaisesRegex(ValueError, wrong[0][1]):
            equations.residual(equations.state(1.0))
        with self.assertRaisesRegex(ValueError, r'stiffness of the load "wind".*\(3, 3, 3\)'):
            model.run(loads=[tegula.NodalForce("u_max", springs, stiffness=springs, name="wind")])

    def test_a_stiffness_that_is_no_derivative_of_the_forces_is_refused(self) -> None:
        model = tegula.Model(cantilever())
        for factor in (10.0, -1.0, 0.99, 0.0):
            def wrong(time: float, positions: Array, factor: float = factor) -> Array:
                return factor * stiffness(time, positions)

            with self.subTest(factor), self.assertRaisesRegex(ValueError, 'stiffness of the load "bed" is not the derivative'):
                model.run(loads=[tegula.NodalForce("u_max", springs, stiffness=wrong, name="bed")])

    def test_functions_of_other_arguments_are_refused(self) -> None:
        with self.assertRaisesRegex(ValueError, "python.u_max.*time, positions, velocities"):
            tegula.NodalForce("u_max", lambda: 0.0)
        with self.assertRaisesRegex(ValueError, "both stiffness and damping"):
            tegula.NodalForce("u_max", lambda t, x, v: v, stiffness=lambda t, x, v: v)
        with self.assertRaisesRegex(ValueError, "arguments of force"):
            tegula.NodalForce("u_max", springs, stiffness=lambda t: 0.0)
        with self.assertRaises(TypeError):
            tegula.NodalForce("u_max", 3.0)  # type: ignore[arg-type]
        # Arguments with a default are the caller's own.
        tegula.Model(cantilever()).run(loads=[tegula.NodalForce("u_max", lambda t, x, gain=0.0: gain * x)])

    def test_models_that_cannot_have_a_load_say_so(self) -> None:
        load = tegula.NodalForce("u_max", springs)
        cases = [
            (cantilever(), tegula.NodalForce("nowhere", springs), "neither a set of the mesh nor a body"),
            (cantilever(analysis={"type": "static", "linear": True}), load, "linear"),
            (cantilever(analysis={"type": "buckling", "modes": 1}), load, "buckling"),
            (cantilever(analysis={"type": "modal", "modes": 1}, loads=[]), load, "modal"),
        ]
        for keys, given, message in cases:
            with self.subTest(message), self.assertRaisesRegex(tegula.ModelError, message):
                tegula.Model(keys).run(loads=[given])
        fourth = {**SWING, "scheme": {"type": "energy-momentum", "order": 4}}
        damper = tegula.NodalForce("u_max", lambda t, x, v: -v)
        with self.assertRaisesRegex(tegula.ModelError, "order"):
            tegula.Model(cantilever(analysis=fourth)).simulation(loads=[damper])
        with self.assertRaisesRegex(tegula.ModelError, "two loads"):
            tegula.Model(cantilever()).run(loads=[load, load])

    def test_a_function_that_reads_its_own_simulation_is_told(self) -> None:
        reads: list[Any] = [
            lambda s: s.positions,
            lambda s: s.time,
            lambda s: s.finished,
            lambda s: s.signals,
            lambda s: s.values(),
            lambda s: s.state,
            lambda s: s.equations,
            lambda s: s.nodes_on("u_max"),
            lambda s: s.advance(),
            lambda s: s.repeat(),
        ]
        met: list[str] = []

        def curious(time: float, positions: Array) -> Array:
            if simulation is None:
                return springs(time, positions)
            met.append(repr(simulation))
            for read in reads:
                with self.assertRaisesRegex(RuntimeError, "middle of a step.*use the arguments"):
                    read(simulation)
            # One that is not under way is read.
            self.assertEqual(other.time, 0.0)
            return springs(time, positions)

        def run() -> None:
            simulation.advance()

        other = tegula.Model(cantilever(analysis=SWING)).simulation()
        simulation: Any
        for in_thread in (False, True):
            with self.subTest(in_thread=in_thread):
                # Forces are evaluated at the beginning, too.
                simulation = None
                simulation = tegula.Model(cantilever(analysis=SWING)).simulation(loads=[tegula.NodalForce("u_max", curious)])
                if in_thread:
                    thread = threading.Thread(target=run, daemon=True)
                    thread.start()
                    thread.join(120.0)
                    self.assertFalse(thread.is_alive(), "the thread waits for ever")
                else:
                    run()
                self.assertAlmostEqual(simulation.time, 1e-3)
        self.assertEqual(set(met), {"<tegula.Simulation in the middle of a step>"})
        self.assertEqual(repr(simulation), "<tegula.Simulation at 0.001 of 0.05>")

        def careless(time: float, positions: Array) -> Array:
            return np.zeros_like(positions) if simulation is None else simulation.positions

        simulation = None
        simulation = tegula.Model(cantilever(analysis=SWING)).simulation(loads=[tegula.NodalForce("u_max", careless)])
        with self.assertRaisesRegex(RuntimeError, "middle of a step"):
            simulation.advance()
        self.assertEqual(simulation.time, 0.0)

    def test_a_law_that_reads_its_own_simulation_is_told(self) -> None:
        law = hooke(1.0, 0.3)
        told: list[str] = []
        begun = False

        def curious(strain: Array) -> tuple[Array, Array, Array]:
            if begun:
                try:
                    simulation.advance()
                except RuntimeError as error:
                    told.append(str(error))
            return law(strain)  # type: ignore[no-any-return]

        # Elements are evaluated in several threads.
        simulation = tegula.Model(rubber_strip([40, 20], 1.02)).simulation(materials={"m": curious})
        begun = True
        simulation.advance()
        self.assertGreater(len(told), 1)
        for message in told:
            self.assertIn("middle of a step", message)

    def test_a_function_that_evaluates_itself_ends(self) -> None:
        depth, deepest = 0, 0

        def endless(time: float, positions: Array) -> Array:
            nonlocal depth, deepest
            depth += 1
            deepest = max(depth, deepest)
            try:
                equations.residual(state)
            finally:
                depth -= 1
            return np.zeros_like(positions)

        equations = tegula.Model(cantilever()).equations(loads=[tegula.NodalForce("u_max", endless)])
        state = equations.state(1.0)
        with self.assertRaisesRegex(RecursionError, "within itself"):
            equations.residual(state)
        self.assertLess(deepest, 20)

        def own(strain: Array) -> tuple[Array, Array, Array]:
            model.run(materials={"m": own})
            return hooke(1.0, 0.3)(strain)  # type: ignore[no-any-return]

        model = tegula.Model(rubber_strip([2, 1], 1.02))
        with self.assertRaisesRegex(RecursionError, "within itself"):
            model.run(materials={"m": own})

    def test_names_of_loads_make_columns_of_their_own(self) -> None:
        model = tegula.Model(cantilever())
        built_in = "edge.u_max"
        self.assertIn(f"load.{built_in}.fz", model.simulation().columns)
        taken = "has the name of a load of the model"
        wrong = [(name, "cannot name a load") for name in ("", "  ", "a,b", 'a"b', "a'b", "a\nb", "a\0b")]
        wrong += [(name, taken) for name in (built_in, f"{built_in}#2", "released", "inertia_relief")]
        for name, message in wrong:
            for begin in (model.run, model.simulation, model.equations):
                with self.subTest(name), self.assertRaisesRegex(tegula.ModelError, message):
                    begin(loads=[tegula.NodalForce("u_max", springs, name=name)])
        for name in ("edge.u_max_", "edges.u_max", "fjäder 1", "released_spring"):
            columns = model.simulation(loads=[tegula.NodalForce("u_max", springs, name=name)]).columns
            self.assertEqual(columns.count(f"load.{name}.fz"), 1)
            self.assertEqual(len(columns), len(set(columns)))
        # A load of a later step.
        steps = [{"name": "rest", "analysis": {"type": "static"}, "loads": []},
                 {"name": "load", "analysis": {"type": "static"}, "loads": cantilever()["loads"]}]
        keys = cantilever(loads=[], steps=steps)
        del keys["analysis"]
        with self.assertRaisesRegex(tegula.ModelError, taken):
            tegula.Model(keys).run(loads=[tegula.NodalForce("u_max", springs, name=built_in)])
        # Names of sets may have commas.
        self.assertEqual(tegula.NodalForce("left,right", springs).name, "python.left_right")

    def test_only_real_numbers_are_taken(self) -> None:
        model = tegula.Model(cantilever())
        masked = np.ma.masked_less(np.diag([1.0, 2.0, 0.0]), 0.5)
        wrong = [
            (np.ones((3, 3), complex), TypeError, "complex numbers"),
            ([["1", "2", "3"]] * 3, TypeError, "text"),
            (np.zeros((3, 3), [("fx", float)]), TypeError, "structured records"),
            (np.zeros((3, 3), "m8[s]"), TypeError, "time differences"),
            (np.zeros((3, 3), "M8[s]"), TypeError, "times"),
            (np.ones((3, 3), bool), TypeError, "truth values"),
            (masked, ValueError, "masked entries"),
            (np.full((3, 3), None), ValueError, "no array of numbers"),
            ([[1.0], [1.0, 2.0]], ValueError, "list is given, and no array of numbers"),
        ]
        for value, kind, message in wrong:
            with self.subTest(message), self.assertRaisesRegex(kind, f'forces of the load "wind".*{message}'):
                model.run(loads=[tegula.NodalForce("u_max", lambda time, value=value: value, name="wind")])
        law = hooke(1.0, 0.3)
        strip = tegula.Model(rubber_strip([4, 2], 1.2))
        with self.assertRaisesRegex(TypeError, 'stress of the law of material "m".*complex'):
            strip.run(materials={"m": lambda strain: (law(strain)[0], law(strain)[1] + 0j, law(strain)[2])})
        whole = np.array([[0, 0, 100]] * 3)
        tips = [
            tip(model.run(loads=[tegula.NodalForce("u_max", lambda time, value=value: value)]))
            for value in (whole.astype(float), whole, whole.astype(np.uint8), whole.astype(np.float32), whole.tolist(), np.ma.array(whole))
        ]
        self.assertEqual(tips, tips[:1] * 6)

    def test_arguments_of_other_kinds_are_refused(self) -> None:
        model = tegula.Model(cantilever())
        self.assertEqual(tip(model.run(loads=None, materials=None)), tip(model.run()))
        wrong: list[tuple[dict[str, Any], str]] = [
            ({"loads": 3}, "loads: a list of tegula.NodalForce is expected, not int"),
            ({"loads": "u_max"}, "loads: a list of tegula.NodalForce is expected, not str"),
            ({"loads": [springs]}, "loads: a tegula.NodalForce is expected, not function"),
            ({"materials": [hooke(1.0, 0.3)]}, "materials: a dictionary .* is expected, not list"),
            ({"materials": {3: hooke(1.0, 0.3)}}, "materials: the name of a material is a text, not int"),
            ({"materials": {"m": 3.0}}, "materials: the law of 'm' is a function .*, not float"),
        ]
        for arguments, message in wrong:
            for begin in (model.run, model.simulation, model.equations):
                with self.subTest(message), self.assertRaisesRegex(TypeError, message):
                    begin(**arguments)
        with self.assertRaisesRegex(TypeError, "name: a text is expected, not int"):
            tegula.NodalForce("u_max", springs, name=3)  # type: ignore[arg-type]

    def test_functions_may_compute_with_the_package_in_any_thread(self) -> None:
        inner = tegula.Model(cantilever(mesh={"type": "plate", "size": [LENGTH, WIDTH], "grid": {"elements": [8, 1]}}))
        whole = tip(inner.run())

        def nested(time: float, positions: Array) -> Array:
            deflection = tip(inner.run())
            return np.outer(positions[:, 2], [0.0, 0.0, LOAD * WIDTH / -deflection / len(positions)])

        keys = cantilever(mesh={"type": "plate", "size": [LENGTH, WIDTH], "grid": {"elements": [8, 1]}})
        found: list[float] = []

        def run() -> None:
            found.append(tip(tegula.Model(keys).run(loads=[tegula.NodalForce("u_max", nested)])))

        threads = [threading.Thread(target=run, daemon=True) for _ in range(2)]
        for thread in threads:
            thread.start()
        run()
        for thread in threads:
            thread.join(120.0)
            self.assertFalse(thread.is_alive(), "a thread waits for ever")
        self.assertEqual(len(found), 3)
        for deflection in found:
            # Springs as stiff as the strip of the same mesh take half of the load.
            self.assertLess(abs(deflection / (0.5 * whole) - 1.0), 1e-5)


# Tensor indices of the components of stresses and strains.
ROWS, COLUMNS = np.array([(0, 0), (1, 1), (0, 1), (2, 2), (0, 2), (1, 2)]).T


def yeoh(strain: Array, c: tuple[float, float, float] = (0.2, -0.005, 0.0005), bulk: float = 400.0) -> tuple[Array, Array, Array]:
    """Yeoh's rubber, ψ = c₁ x + c₂ x² + c₃ x³ + κ/2 (J − 1)² with x = J^(−2/3) I₁ − 3."""
    right = np.zeros((len(strain), 3, 3))
    for value, i, j, double in zip(strain.T, ROWS, COLUMNS, (2.0, 2.0, 1.0, 2.0, 1.0, 1.0)):
        right[:, i, j] = right[:, j, i] = (i == j) + double * value
    square = np.linalg.det(right)
    square[square <= 0.0] = np.nan
    volume = np.sqrt(square)[:, None]
    inverse = np.linalg.inv(right)
    unit = np.eye(3)[ROWS, COLUMNS][None, :]
    b = inverse[:, ROWS, COLUMNS]
    trace = np.trace(right, axis1=1, axis2=2)[:, None]
    first = volume ** (-2.0 / 3.0)
    both = 0.5 * (
        inverse[:, ROWS[:, None], ROWS] * inverse[:, COLUMNS[:, None], COLUMNS]
        + inverse[:, ROWS[:, None], COLUMNS] * inverse[:, COLUMNS[:, None], ROWS]
    )

    def outer(p: Any, q: Any) -> Any:
        return p[:, :, None] * q[:, None, :]

    x = (first * trace - 3.0)[:, 0]
    gradient = 2.0 * first * (unit - trace / 3.0 * b)
    wide = first[:, :, None], trace[:, :, None], volume[:, :, None]
    units = np.repeat(unit, len(strain), axis=0)
    curvature = 4.0 * wide[0] * (
        -(outer(units, b) + outer(b, units)) / 3.0 + wide[1] / 9.0 * outer(b, b) + wide[1] / 3.0 * both
    )
    slope, bend = c[0] + x * (2.0 * c[1] + 3.0 * c[2] * x), 2.0 * c[1] + 6.0 * c[2] * x
    energy = x * (c[0] + x * (c[1] + c[2] * x)) + 0.5 * bulk * (volume[:, 0] - 1.0) ** 2
    stress = slope[:, None] * gradient + bulk * (volume - 1.0) * volume * b
    tangent = slope[:, None, None] * curvature + bend[:, None, None] * outer(gradient, gradient)
    tangent += bulk * (wide[2] * (2.0 * wide[2] - 1.0) * outer(b, b) - 2.0 * (wide[2] - 1.0) * wide[2] * both)
    return energy, stress, tangent


def hooke(young: float, poisson: float) -> Any:
    """Isotropic St. Venant–Kirchhoff law."""
    shear = young / (2.0 * (1.0 + poisson))
    lame = young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson))
    direct = ROWS == COLUMNS
    c = np.diag(np.where(direct, 2.0 * shear, shear)) + lame * np.outer(direct, direct)

    def law(strain: Array) -> tuple[Array, Array, Array]:
        stress = strain @ c
        return 0.5 * (stress * strain).sum(axis=1), stress, np.broadcast_to(c, (len(strain), 6, 6))

    return law


def rubber_strip(elements: list[int], stretch: float, directions: str = "x") -> dict[str, Any]:
    """A strip between planes of symmetry, pulled along x, or along x and y."""

    def plane(on: str, normal: list[float]) -> dict[str, Any]:
        return {"type": "symmetry", "on": on, "normal": normal}

    def pull(on: str, axis: str, length: float) -> dict[str, Any]:
        return {"type": "prescribe", "on": on, "component": axis, "of": "position", "value": (stretch - 1.0) * length}

    conditions = [plane("u_min", [1.0, 0.0, 0.0]), plane("v_min", [0.0, 1.0, 0.0]), {"type": "fix", "on": "all", "position": ["z"]}]
    conditions.append(pull("u_max", "x", 2.0))
    if directions == "xy":
        conditions.append(pull("v_max", "y", 1.0))
    return {
        "analysis": {"type": "static", "load_steps": 8},
        "mesh": {"type": "plate", "size": [2.0, 1.0], "grid": {"elements": elements}},
        "materials": {"m": {"type": "neo-hookean", "shear": 0.4, "bulk": 400.0}},
        "sections": [{"material": "m", "thickness": 0.1, "element": "cm"}],
        "conditions": conditions,
        "output": {"pictures": False, "fields": []},
    }


class Materials(unittest.TestCase):
    def nominal(self, result: tegula.Result) -> float:
        return abs(float(result.history["support.u_max.fx"][-1])) / (1.0 * 0.1)

    def test_rubber_in_uniaxial_and_biaxial_tension(self) -> None:
        c1, c2, c3 = 0.2, -0.005, 0.0005
        for directions, stretch in (("x", 3.0), ("xy", 1.5)):
            with self.subTest(directions):
                result = tegula.Model(rubber_strip([4, 2], stretch, directions)).run(materials={"m": yeoh})
                # Incompressible: σ λ⁻¹ = 2 (λ − λ₃²/λ) ψ' with the stretch λ₃ of the thickness.
                thin = stretch**-0.5 if directions == "x" else stretch**-2
                x = (1.0 + (directions == "xy")) * stretch**2 + (2.0 - (directions == "xy")) * thin**2 - 3.0
                exact = 2.0 * (stretch - thin**2 / stretch) * (c1 + 2.0 * c2 * x + 3.0 * c3 * x * x)
                self.assertLess(abs(self.nominal(result) / exact - 1.0), 5e-3)

    def test_hookes_law_is_the_law_of_the_program(self) -> None:
        young, poisson = 7.0, 0.3
        keys = rubber_strip([3, 2], 1.2)
        own = tegula.Model(keys).equations(materials={"m": hooke(young, poisson)})
        keys["materials"] = {"m": {"type": "isotropic", "young": young, "poisson": poisson}}
        same = tegula.Model(keys).equations()
        increment = 0.05 * np.cos(1.7 * np.arange(same.unknowns))
        residuals = [e.residual(e.moved(e.state(1.0), increment)) for e in (own, same)]
        self.assertGreater(np.abs(residuals[1]).max(), 1e-3)
        self.assertLess(np.abs(residuals[0] - residuals[1]).max(), 1e-12 * np.abs(residuals[1]).max())

    def test_a_call_evaluates_the_points_of_many_elements(self) -> None:
        counts: list[int] = []

        def counted(strain: Array) -> tuple[Array, Array, Array]:
            counts.append(len(strain))
            return hooke(1.0, 0.3)(strain)  # type: ignore[no-any-return]

        calls, points = [], []
        for elements in ([4, 2], [16, 8]):
            counts.clear()
            keys = rubber_strip(elements, 1.2)
            # Strains differ from element to element.
            keys["conditions"][1] = {"type": "clamp", "on": "u_min"}
            tegula.Model(keys).run(materials={"m": counted})
            calls.append(sum(size > 1 for size in counts))
            points.append(sum(counts))
        self.assertGreater(points[1], 8 * points[0])
        self.assertLess(calls[1], 1.5 * calls[0])

    def test_mistakes_of_a_law_name_the_material(self) -> None:
        law = hooke(1.0, 0.3)
        zero = np.zeros((6, 6))
        zero[0, 1] = 1.0
        wrong = [
            (lambda strain: law(strain)[1], 'law of material "m" gives no tuple'),
            (lambda strain: (*law(strain)[:2], np.eye(6)), r'tangent of the law of material "m".*\(6, 6\)'),
            (lambda strain: (*law(strain)[:2], law(strain)[2] + zero), 'law of material "m" has a tangent that is not symmetric'),
            (lambda strain: (law(strain)[0], law(strain)[1] + 1.0, law(strain)[2]), "stress without strain"),
        ]
        model = tegula.Model(rubber_strip([4, 2], 1.2))
        for function, message in wrong:
            with self.subTest(message), self.assertRaisesRegex(ValueError, message):
                model.run(materials={"m": function})
        mistake = Mistake("not in the tables")

        def limited(strain: Array) -> tuple[Array, Array, Array]:
            if np.abs(strain).max() > 0.05:
                raise mistake
            return law(strain)  # type: ignore[no-any-return]

        with self.assertRaises(Mistake) as caught:
            model.run(materials={"m": tegula.ElasticLaw(limited)})
        self.assertIs(caught.exception, mistake)
        with self.assertRaisesRegex(tegula.ModelError, "no such material"):
            model.run(materials={"n": law})

    def test_laws_whose_parts_do_not_fit_are_refused(self) -> None:
        law = hooke(2.0, 0.25)
        # λ = μ = 0.8: S_xx = 0.8 (0.725 + 2·1.037)·1e-3 = 2.2392e-3 at the strain of the check; C_xx,xx = 2.4.
        halves = np.where(ROWS == COLUMNS, 1.0, 0.5)

        def parts(change: Any) -> Any:
            return lambda strain: change(*law(strain), strain)

        wrong = [
            (parts(lambda w, s, c, e: (2.0 * w, s, c)), r"stress xx = 2\.23920*e-3 .* derivative 4\.47840*e-3 by xx"),
            (parts(lambda w, s, c, e: (0.0 * w, s, c)), r"stress xx = 2\.23920*e-3 .* derivative 0\.0*e0 by xx"),
            (parts(lambda w, s, c, e: (w, -s, c)), r"stress xx = -2\.23920*e-3"),
            (parts(lambda w, s, c, e: (w, s, 0.5 * c)), r"tangent 1\.20*e0 of stress (xx|yy|zz) by strain (xx|yy|zz) .* derivative 2\.40*e0"),
            (parts(lambda w, s, c, e: (w, s, 0.0 * c)), r"tangent 0\.0*e0 of stress"),
            # Strains xy in place of 2xy.
            (parts(lambda w, s, c, e: (w, s * halves, c)), "stress xz = "),
            (parts(lambda w, s, c, e: (w, s, c * np.outer(halves, halves))), "tangent .* of stress (xy|xz|yz) by strain 2"),
            # Two components changed over.
            (parts(lambda w, s, c, e: (w, s[:, [0, 1, 3, 2, 4, 5]], c)), "stress (zz|xy) = "),
        ]
        model = tegula.Model(rubber_strip([4, 2], 1.2))
        for function, message in wrong:
            for begin in (model.run, lambda materials: model.simulation(materials=materials).advance()):
                with self.subTest(message), self.assertRaisesRegex(ValueError, f'the law of material "m" has .*{message}'):
                    begin(materials={"m": function})

    def test_laws_that_fit_are_taken(self) -> None:
        law = hooke(2.0, 0.25)
        exact = self.nominal(tegula.Model(rubber_strip([4, 2], 1.02)).run(materials={"m": law}))

        def offset(strain: Array) -> tuple[Array, Array, Array]:
            energy, stress, tangent = law(strain)
            return energy + 1e5, stress, tangent

        def single(strain: Array) -> tuple[Array, Array, Array]:
            energy, stress, tangent = law(strain)
            return energy.astype(np.float32), stress, tangent

        def limited(strain: Array) -> tuple[Array, Array, Array]:
            energy, stress, tangent = law(strain)
            # One-sided: of the neighbours of the strain of the check some are beyond.
            return np.where(strain[:, 4] > 0.73e-3, np.nan, energy), stress, tangent

        for function in (offset, single, limited):
            with self.subTest(function.__name__):
                result = tegula.Model(rubber_strip([4, 2], 1.02)).run(materials={"m": function})
                self.assertLess(abs(self.nominal(result) / exact - 1.0), 1e-9)
                # Energies are those above the one without strain, from which no strain is concluded.
                self.assertLess(result.history["strain"][-1], 1.0)
                self.assertEqual(result.warnings, [])
        # Nearly incompressible rubber, stiff or soft, and one that stiffens exponentially.
        for bulk in (4e-3, 400.0, 4e6):
            tegula.Model(rubber_strip([2, 1], 1.02)).run(materials={"m": functools.partial(yeoh, bulk=bulk)})

        def fung(strain: Array) -> tuple[Array, Array, Array]:
            energy, stress, tangent = law(strain)
            growth = np.exp(500.0 * energy)
            return (
                (growth - 1.0) / 500.0,
                growth[:, None] * stress,
                growth[:, None, None] * (tangent + 500.0 * stress[:, :, None] * stress[:, None, :]),
            )

        tegula.Model(rubber_strip([2, 1], 1.02)).run(materials={"m": fung})

    def test_strains_that_a_law_leaves_out_end_the_analysis(self) -> None:
        law = hooke(1.0, 0.3)

        def limited(strain: Array) -> tuple[Array, Array, Array]:
            energy, stress, tangent = law(strain)
            return np.where(np.abs(strain).max(axis=1) > 0.05, np.nan, energy), stress, tangent

        with self.assertRaisesRegex(tegula.AnalysisError, "material law could not be evaluated"):
            tegula.Model(rubber_strip([4, 2], 1.2)).run(materials={"m": limited})


if __name__ == "__main__":
    unittest.main()
