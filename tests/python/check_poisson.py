"""Solves Poisson problems by scikit-fem on meshes of falling size; the error must fall at the right order.

usage: check_poisson.py cube|ball ORDER_P1|- ORDER_P2 MESH...

On the cube [-1, 1]^3 the solution is a product of sines; on the unit ball it is 1 - r^2, whose order with P2 is 3 only
where the boundary is curved as the ball's.
"""
import sys

import meshio
import numpy as np
import skfem
from reading import check
from skfem.io.meshio import from_meshio
from skfem.models.poisson import laplace

PI = np.pi
PROBLEMS = {
    "cube": (lambda x: np.prod(np.sin(PI * x), axis=0), lambda x: 3 * PI**2 * np.prod(np.sin(PI * x), axis=0)),
    "ball": (lambda x: 1 - (x**2).sum(axis=0), lambda x: 6 + 0 * x[0]),
}


def error(path, element, exact, load):
    """Size of the elements, and the L2 norm of the error."""
    basis = skfem.Basis(from_meshio(meshio.read(path)), element, intorder=6)
    stiffness = laplace.assemble(basis)
    loads = skfem.LinearForm(lambda v, w: load(w.x) * v).assemble(basis)
    solution = skfem.solve(*skfem.condense(stiffness, loads, D=basis.get_dofs()))
    squares = skfem.Functional(lambda w: (w["u"] - exact(w.x)) ** 2).assemble(basis, u=basis.interpolate(solution))
    volume = skfem.Functional(lambda w: 1 + 0 * w.x[0]).assemble(basis)
    return (volume / basis.mesh.nelements) ** (1 / 3), np.sqrt(squares)


def main(problem, p1, p2, *meshes):
    for element, wanted in [(skfem.ElementTetP1(), p1), (skfem.ElementTetP2(), p2)]:
        if wanted == "-":
            continue
        sizes, errors = np.log([error(path, element, *PROBLEMS[problem]) for path in meshes]).T
        order = np.polyfit(sizes, errors, 1)[0]
        name = type(element).__name__
        check(abs(order - float(wanted)) < 0.4, f"{name}: order {order}, not {wanted}; errors {np.exp(errors)}")
        print(f"{problem}, {name}: order {order:.2f}")


if __name__ == "__main__":
    main(*sys.argv[1:])
