"""Residual, tangent, mass and constraints as functions of a state, against facts that do not come from them."""

import copy
import pickle
import sys
import unittest
from typing import Any
from unittest import mock

import numpy as np
from test_package import LENGTH, LOAD, SWING, THICKNESS, WIDTH, YOUNG, cantilever

import tegula

DENSITY = 7850.0
STEEL = {"steel": {"type": "isotropic", "young": YOUNG, "poisson": 0.3, "density": DENSITY}}
MASS = DENSITY * LENGTH * WIDTH * THICKNESS
# Plate that a spherical joint and a spring hold, with a body on its other end.
BODY = {"name": "disk", "at": [LENGTH, 0.5, 0.0], "mass": 300.0, "inertia": [20.0, 30.0, 40.0], "attached": ["u_max"]}


def strip(element: str = "ems", **changes: Any) -> dict[str, Any]:
    """A cantilever with Poisson's effect, bent far by its load."""
    keys = cantilever(
        materials=STEEL,
        sections=[{"material": "steel", "thickness": THICKNESS, "element": element}],
        mesh={"type": "plate", "size": [LENGTH, WIDTH], "grid": {"elements": [6, 1]}},
        loads=[{"type": "edge", "on": "u_max", "value": [0.0, 0.0, 500.0 * LOAD]}],
    )
    return {**keys, **changes}


def jointed() -> dict[str, Any]:
    """A plate on a spherical joint and a spring between the ground and the body on its end, under gravity."""
    joint = {"type": "spherical", "name": "ball", "between": ["ground", "hub"], "at": [0.0, 0.5, 0.0]}
    hub = {"name": "hub", "at": [0.0, 0.5, 0.0], "mass": 10.0, "inertia": [1.0, 1.0, 1.0], "attached": ["u_min"]}
    springs = [
        {"name": f"s{i}", "between": ["ground", "disk"], "points": [[LENGTH, 0.5 + y, z], [LENGTH, 0.5 + 0.5 * y, 0.0]], "stiffness": 2e4}
        for i, (y, z) in enumerate([(4.0, 4.0), (-4.0, 4.0), (0.0, -4.0)])
    ]
    return strip(
        bodies=[hub, BODY],
        joints=[joint],
        springs=springs,
        conditions=[],
        loads=[{"type": "gravity", "value": [0.0, 0.0, -9.81]}],
    )


class EquationsOfModels(unittest.TestCase):
    def setUp(self) -> None:
        try:
            import scipy.sparse.linalg  # type: ignore[import-not-found, import-untyped, unused-ignore]
        except ImportError as missing:
            self.skipTest(str(missing))
        self.linalg: Any = scipy.sparse.linalg
        self.sparse: Any = scipy.sparse

    def derivative(self, equations: tegula.Equations, state: tegula.State) -> np.ndarray[Any, Any]:
        """Minus the derivative of the residual, by central differences of all free degrees of freedom."""
        h, columns = 1e-6, []
        for direction in np.eye(equations.unknowns):
            behind, ahead = (equations.residual(equations.moved(state, s * h * direction)) for s in (-1.0, 1.0))
            columns.append((behind - ahead) / (2.0 * h))
        return np.column_stack(columns)

    def test_the_tangent_is_minus_the_derivative_of_the_residual(self) -> None:
        pressure = {"type": "pressure", "on": "all", "value": 2e5}
        models = {element: strip(element) for element in ("ems", "mitc4")}
        models["pressure"] = strip(loads=[pressure])
        models["jointed"] = jointed()
        for name, keys in models.items():
            simulation = tegula.Model(keys).simulation()
            simulation.advance()
            equations, state = simulation.equations, simulation.state
            tangent = equations.tangent(state).toarray()
            expected = self.derivative(equations, state)
            size = np.abs(expected).max()
            self.assertGreater(size, 0.0)
            self.assertLess(np.abs(tangent - expected).max(), 1e-7 * size, name)
            # Pressure on a surface with a free boundary has no potential.
            skew = np.abs(tangent - tangent.T).max()
            self.assertEqual(skew > 1e-9 * size, name == "pressure", name)

    def test_newtons_method_finds_the_equilibrium_of_the_program(self) -> None:
        for element in ("ems", "mitc4"):
            model = tegula.Model(strip(element))
            simulation = model.simulation()
            simulation.advance()
            self.assertEqual(simulation.time, 1.0)
            equations = model.equations()
            state = equations.state(time=1.0)
            for _ in range(60):
                change = self.linalg.spsolve(equations.tangent(state), equations.residual(state))
                size = np.abs(change).max()
                state = equations.moved(state, min(1.0, 0.3 / size) * change)
                if size < 1e-10:
                    break
            deflection = np.abs(simulation.state.displacements).max()
            self.assertGreater(deflection, 0.3 * LENGTH)
            difference = np.abs(state.displacements - simulation.state.displacements).max()
            self.assertLess(difference, 1e-9 * deflection, element)

    def test_joints_are_solved_with_their_constraints(self) -> None:
        model = tegula.Model(jointed())
        simulation = model.simulation()
        simulation.advance()
        equations = model.equations()
        self.assertEqual(equations.joints, ["ball"] * 3)
        state = equations.state(time=1.0)
        for _ in range(40):
            values, gradients = equations.constraints(state)
            matrix = self.sparse.block_array([[equations.tangent(state), gradients.T], [gradients, None]], format="csc")
            change = self.linalg.spsolve(matrix, np.concatenate([equations.residual(state), -values]))
            size = np.abs(change[: equations.unknowns]).max()
            moved = equations.moved(state, change[: equations.unknowns])
            state = moved.replace(multipliers=state.multipliers + change[equations.unknowns :])
            if size < 1e-11:
                break
        found = simulation.state
        self.assertGreater(np.abs(found.displacements).max(), 1e-3)
        np.testing.assert_allclose(state.displacements, found.displacements, rtol=0.0, atol=1e-9)
        # The joint and the springs carry the weight.
        self.assertGreater(np.abs(found.multipliers).max(), 0.1 * 9.81 * MASS)
        np.testing.assert_allclose(state.multipliers, found.multipliers, rtol=1e-6, atol=1e-3)

    def test_gradients_of_constraints_are_their_derivatives(self) -> None:
        simulation = tegula.Model(jointed()).simulation()
        simulation.advance()
        equations, state = simulation.equations, simulation.state
        x = np.random.default_rng(3).standard_normal(equations.unknowns)
        values = [equations.constraints(equations.moved(state, h * x))[0] for h in (-1e-6, 1e-6)]
        expected = (values[1] - values[0]) / 2e-6
        self.assertGreater(np.abs(expected).min(), 1e-3)
        np.testing.assert_allclose(equations.constraints(state)[1] @ x, expected, rtol=1e-7)

    def test_eigenvalues_are_the_natural_frequencies(self) -> None:
        model = tegula.Model(strip(analysis={"type": "modal", "modes": 5}, loads=[]))
        equations = model.equations()
        state = equations.state()
        values = self.linalg.eigsh(equations.tangent(state), 5, equations.mass(state), sigma=0.0, return_eigenvectors=False)
        found = np.sqrt(np.sort(values)) / (2.0 * np.pi)
        np.testing.assert_allclose(found, model.run().frequencies, rtol=1e-8)

    def test_the_mass_matrix_has_the_mass_of_the_model(self) -> None:
        for keys, mass in ((strip(conditions=[]), MASS), (jointed(), MASS + 310.0)):
            equations = tegula.Model({**keys, "analysis": {"type": "modal", "modes": 1}, "loads": []}).equations()
            state = equations.state()
            matrix = equations.mass(state)
            numbers = equations.numbers[np.array(equations.kinds) == "position"]
            for axis in range(3):
                along = np.zeros(equations.unknowns)
                along[numbers[numbers[:, axis] >= 0, axis]] = 1.0
                self.assertLess(abs(along @ (matrix @ along) / mass - 1.0), 1e-12)
                # All positions move by the same, also those that bodies carry.
                moved = (equations.expansion(state) @ along).reshape(-1, 3)
                of_positions = moved[np.array(equations.kinds) == "position"]
                np.testing.assert_array_equal(of_positions, np.broadcast_to(np.eye(3)[axis], of_positions.shape))

    def test_the_mass_matrix_has_the_kinetic_energy_of_the_motion(self) -> None:
        for keys in (strip(analysis=SWING), {**jointed(), "analysis": SWING}):
            simulation = tegula.Model(keys).simulation()
            simulation.advance(5)
            equations, state = simulation.equations, simulation.state
            expansion = equations.expansion(state)
            velocities = state.velocities.ravel()
            rates = self.linalg.spsolve((expansion.T @ expansion).tocsc(), expansion.T @ velocities)
            # Velocities of directors of bodies leave the rotations by a term of second order in the time step.
            np.testing.assert_allclose(expansion @ rates, velocities, rtol=0.0, atol=1e-6 * np.abs(velocities).max())
            kinetic = 0.5 * rates @ (equations.mass(state) @ rates)
            self.assertGreater(kinetic, 1.0)
            self.assertLess(abs(kinetic / simulation.energies.kinetic - 1.0), 1e-9)

    def test_the_equations_of_a_simulation_have_its_signals(self) -> None:
        keys = strip(analysis=SWING, amplitudes={"force": {"type": "constant", "value": 1.0}})
        keys["loads"][0]["amplitude"] = "force"
        simulation = tegula.Model(keys).simulation(signals=["force"])
        equations, state = simulation.equations, simulation.equations.state()
        loads = {}
        for value in (1.0, -2.0):
            simulation.set("force", value)
            loads[value] = equations.residual(state)
        self.assertLess(abs(loads[1.0].sum() / (500.0 * LOAD * WIDTH) - 1.0), 1e-12)
        np.testing.assert_allclose(loads[-2.0], -2.0 * loads[1.0], rtol=1e-14)

    def test_matrices_without_scipy_name_the_package(self) -> None:
        equations = tegula.Model(strip()).equations()
        with mock.patch.dict(sys.modules, {"scipy": None, "scipy.sparse": None}):
            for matrix in (equations.tangent, equations.mass, equations.constraints, equations.expansion):
                with self.assertRaisesRegex(ImportError, "pip install scipy"):
                    matrix(equations.state())
            self.assertEqual(equations.residual(equations.state()).shape, (equations.unknowns,))

    def test_analyses_without_a_tangent_are_refused(self) -> None:
        analysis = {"type": "transient", "end_time": 1e-3, "scheme": {"type": "explicit"}}
        equations = tegula.Model(strip(analysis=analysis)).equations()
        self.assertGreater(np.abs(equations.residual(equations.state(1e-3))).max(), 1.0)
        for matrix in (equations.tangent, equations.mass):
            with self.assertRaisesRegex(ValueError, "explicit"):
                matrix(equations.state())


class Rows(unittest.TestCase):
    """The map from rows to nodes and components."""

    def test_numbers_tell_what_each_row_belongs_to(self) -> None:
        equations = tegula.Model(strip()).equations()
        numbers, nodes, kinds = equations.numbers, equations.nodes, np.array(equations.kinds)
        self.assertEqual(numbers.shape, (28, 3))
        self.assertEqual(sorted(numbers[numbers >= 0]), list(range(equations.unknowns)))
        self.assertEqual(set(equations.bodies), {""})
        self.assertEqual([(nodes == node).sum() for node in range(14)], [2] * 14)
        positions = equations.reference[kinds == "position"]
        np.testing.assert_allclose(positions[np.argsort(nodes[kinds == "position"])][-1], [LENGTH, WIDTH, 0.0])
        clamped = np.isin(nodes, np.flatnonzero(positions[:, 0] == 0.0))
        self.assertTrue((numbers[clamped] == -1).all() and (numbers[~clamped] >= 0).all())
        # The load is that of the rows which are displacements along z at the end.
        residual = equations.residual(equations.state(1.0))
        loaded = numbers[(kinds == "position") & (equations.reference[:, 0] == LENGTH), 2]
        np.testing.assert_allclose(residual[loaded], 0.5 * 500.0 * LOAD * WIDTH, rtol=1e-12)
        self.assertLess(np.abs(np.delete(residual, loaded)).max(), 1e-6)

    def test_bodies_have_a_rotation_in_place_of_their_directors(self) -> None:
        equations = tegula.Model(jointed()).equations()
        bodies, kinds = np.array(equations.bodies), np.array(equations.kinds)
        self.assertEqual([(bodies == name).sum() for name in ("hub", "disk")], [4, 4])
        directors = equations.numbers[(bodies == "disk") & (kinds == "director")]
        self.assertTrue((directors[0] >= 0).all() and (directors[1:] == -1).all())
        self.assertTrue((equations.nodes[bodies == "disk"] == -1).all())
        rotation = np.zeros(equations.unknowns)
        rotation[directors[0]] = [0.0, 0.0, 0.5 * np.pi]
        turned = equations.moved(equations.state(), rotation)
        now = (equations.reference + turned.displacements)[(bodies == "disk") & (kinds == "director")]
        np.testing.assert_allclose(now, [[0, 1, 0], [-1, 0, 0], [0, 0, 1]], atol=1e-15)

    def test_supports_that_prescribe_are_in_the_state(self) -> None:
        moved = {"type": "prescribe", "on": "u_max", "of": "position", "component": "z", "value": 0.25}
        keys = strip(conditions=[{"type": "clamp", "on": "u_min"}, moved], loads=[])
        equations = tegula.Model(keys).equations()
        displacements = equations.state(0.5).displacements
        at_end = (np.array(equations.kinds) == "position") & (equations.reference[:, 0] == LENGTH)
        np.testing.assert_allclose(displacements[at_end, 2], 0.125)
        self.assertEqual(np.abs(displacements[~at_end]).max(), 0.0)


class States(unittest.TestCase):
    def test_states_are_changed_by_values_that_fit(self) -> None:
        equations = tegula.Model(strip()).equations()
        state = equations.state()
        shape = state.displacements.shape
        other = state.replace(time=0.5, velocities=np.ones(shape), displacements=np.zeros(shape).tolist())
        self.assertEqual((other.time, other.velocities.sum(), state.velocities.sum()), (0.5, float(np.prod(shape)), 0.0))
        self.assertNotEqual(other, state)
        self.assertEqual(other.replace(time=0.0).displacements.tolist(), state.displacements.tolist())
        for field in (np.ones((shape[0], 2)), np.ones((1, 3)), np.full(shape, np.nan), np.full(shape, np.inf)):
            with self.assertRaisesRegex(ValueError, "accelerations"):
                state.replace(accelerations=field)
        with self.assertRaisesRegex(ValueError, "multipliers: 1 values are given for 0"):
            state.replace(multipliers=[1.0])
        for wrong in (np.full(equations.unknowns, np.nan), np.zeros(3)):
            with self.assertRaisesRegex(ValueError, "increment"):
                equations.moved(state, wrong)
        for time in (float("nan"), float("inf")):
            with self.assertRaisesRegex(ValueError, "time"):
                equations.state(time)

    def test_arrays_of_states_are_read_only_and_not_copied_again(self) -> None:
        state = tegula.Model(strip()).equations().state()
        arrays = (state.displacements, state.velocities, state.accelerations, state.multipliers)
        self.assertEqual([array.flags.writeable for array in arrays], [False] * 4)
        with self.assertRaisesRegex(ValueError, "read-only"):
            state.displacements[0, 0] = 1.0
        self.assertTrue(np.shares_memory(state.displacements, state.displacements))

    def test_states_of_other_models_are_refused(self) -> None:
        equations, other = tegula.Model(strip()).equations(), tegula.Model(jointed())
        with self.assertRaisesRegex(ValueError, "another model"):
            equations.residual(other.equations().state())
        with self.assertRaisesRegex(ValueError, "another model"):
            other.simulation(start=equations.state())

    def test_states_of_other_meshes_of_as_many_nodes_are_refused(self) -> None:
        state = tegula.Model(strip()).equations().state()
        turned = {"type": "plate", "size": [LENGTH, WIDTH], "grid": {"elements": [1, 6]}}
        longer = {"type": "plate", "size": [2.0 * LENGTH, WIDTH], "grid": {"elements": [6, 1]}}
        for other in (strip(mesh=turned), strip(mesh=longer), strip("mitc4")):
            equations = tegula.Model(other).equations()
            self.assertEqual(equations.state().displacements.shape, state.displacements.shape)
            with self.assertRaisesRegex(ValueError, "another model: its nodes or its elements are others"):
                equations.residual(state)
        stiffer = [{"material": "steel", "thickness": 2.0 * THICKNESS, "element": "ems"}]
        tegula.Model(strip(sections=stiffer)).equations().residual(state)

    def test_simulations_do_not_start_with_directors_of_another_length(self) -> None:
        model = tegula.Model(strip("mitc4", analysis=SWING))
        simulation = model.simulation()
        simulation.advance()
        moved = simulation.state.displacements.copy()
        moved[-1] += 0.1
        with self.assertRaisesRegex(ValueError, "the director of node [0-9]+ has not its length of 1"):
            model.simulation(start=simulation.state.replace(displacements=moved))

    def test_what_is_no_state_is_a_type_error(self) -> None:
        model = tegula.Model(strip())
        equations = model.equations()
        for wrong in (None, 3, np.zeros((2, 3))):
            with self.assertRaisesRegex(TypeError, "a tegula.State is expected"):
                equations.residual(wrong)  # type: ignore[arg-type]
        with self.assertRaisesRegex(TypeError, "a tegula.State is expected, not int"):
            model.simulation(start=3)  # type: ignore[arg-type]
        with self.assertRaisesRegex(ValueError, r"increment: the shape is \([0-9]+, 1\), and \(n,\) is expected"):
            equations.moved(equations.state(), np.zeros((equations.unknowns, 1)))

    def test_states_that_move_supports_are_refused(self) -> None:
        simulation = tegula.Model(strip(analysis=SWING)).simulation()
        for _ in range(3):
            simulation.advance()
        held = tegula.Model(strip(analysis=SWING, conditions=[{"type": "clamp", "on": on} for on in ("u_min", "u_max")]))
        with self.assertRaisesRegex(ValueError, "node [0-9]+ moves, or is elsewhere, where this model holds it"):
            held.simulation(start=simulation.state)

    def test_simulations_start_from_states_of_their_kind_of_analysis(self) -> None:
        analyses: dict[str, dict[str, Any]] = {
            "static": {"type": "static", "load_steps": 4},
            "path": {"type": "path", "max_steps": 3},
            "transient energy-momentum": SWING,
            "transient newmark": {**SWING, "scheme": {"type": "newmark"}},
        }
        models = {kind: tegula.Model(strip(analysis=analysis)) for kind, analysis in analyses.items()}
        states = {}
        for kind, model in models.items():
            simulation = model.simulation()
            simulation.advance()
            states[kind] = simulation.state
        for kind, model in models.items():
            for other, state in states.items():
                if other == kind:
                    self.assertEqual(model.simulation(start=state).state, state)
                    continue
                with self.assertRaisesRegex(ValueError, f"one of a {other} analysis, and the analysis of the model is {kind}$"):
                    model.simulation(start=state)
            with self.assertRaisesRegex(ValueError, "no analysis has reached the state"):
                model.simulation(start=model.equations().state())

    def test_simulations_continue_under_other_loads(self) -> None:
        simulation = tegula.Model(strip(analysis=SWING)).simulation()
        simulation.advance(3)
        free = tegula.Model(strip(analysis=SWING, loads=[])).simulation(start=simulation.state)
        energy = free.energies.kinetic + free.energies.strain
        self.assertGreater(energy, 1.0)
        free.advance(10)
        self.assertAlmostEqual(free.time, 13e-3)
        self.assertLess(abs((free.energies.kinetic + free.energies.strain) / energy - 1.0), 1e-9)

    def test_forces_that_are_not_finite_are_errors(self) -> None:
        equations = tegula.Model(strip()).equations()
        state = equations.state()
        huge = state.replace(displacements=np.full(state.displacements.shape, 1e200) * equations.reference)
        with self.assertRaisesRegex(tegula.AnalysisError, "not finite"):
            equations.residual(huge)

    def test_simulations_continue_from_pickled_states_to_the_last_bit(self) -> None:
        for keys in (strip(analysis=SWING), {**jointed(), "analysis": SWING}, strip(analysis={"type": "static", "load_steps": 4})):
            model = tegula.Model(keys)
            simulation = model.simulation()
            simulation.advance(2)
            state = simulation.state
            read = pickle.loads(pickle.dumps((model, state)))
            self.assertEqual(read[1], state)
            self.assertEqual(copy.deepcopy(state), state)
            again = read[0].simulation(start=read[1])
            self.assertEqual(again.time, simulation.time)
            for each in (simulation, again):
                each.advance(2)
            np.testing.assert_array_equal(again.displacements, simulation.displacements)
            self.assertEqual(again.energies, simulation.energies)
            self.assertEqual(again.values(), simulation.values())
            self.assertEqual(again.state, simulation.state)
            self.assertNotEqual(again.state, state)

    def test_damaged_pickles_of_states_are_refused(self) -> None:
        function, (dump, middle, analysis, mesh) = tegula.Model(strip()).equations().state().__reduce__()
        with self.assertRaisesRegex(ValueError, "cannot be read"):
            function(dump[: len(dump) // 2], middle, analysis, mesh)

    def test_simulations_and_equations_say_why_they_are_not_pickled(self) -> None:
        model = tegula.Model(strip())
        for made, remedy in ((model.simulation(), "start=state"), (model.equations(), r"Model.equations\(\)")):
            for refused in (pickle.dumps, copy.copy, copy.deepcopy):
                with self.assertRaisesRegex(TypeError, remedy):
                    refused(made)
        with self.assertRaisesRegex(TypeError, "Simulation.state"):
            tegula.State()


if __name__ == "__main__":
    unittest.main()
