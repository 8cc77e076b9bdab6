"""The coefficients of ROS34PW2, as data.

Linearly implicit Rosenbrock–W method of order 3 with 4 stages: L-stable, stiffly accurate, and of its order
with any approximate Jacobian; embedded method of order 2; dense output of order 3 (2 with an approximate
Jacobian). Source: J. Rang and L. Angermann 2005, BIT Numer Math 45:761; the dense output as in PETSc's
TSROSW. That they are right is shown in tests/kernel/integration/test_implicit.py.

Stage i, counted from 1: (1 − hγA)(k_i + s_i) = f(y + h Σ_j ALPHA[i][j] k_j) + s_i with
s_i = Σ_j GAMMA[i][j] k_j / γ and A the approximate Jacobian.
"""

ORDER = 3
GAMMA_DIAGONAL = 0.43586652150845900

# fmt: off
ALPHA: dict[int, dict[int, float]] = {
    2: {1: 0.87173304301691801},
    3: {1: 0.84457060015369423, 2: -0.11299064236484185},
    4: {3: 1.0},
}
GAMMA: dict[int, dict[int, float]] = {
    2: {1: -0.87173304301691801},
    3: {1: -0.90338057013044082, 2: 0.054180672388095326},
    4: {1: 0.24212380706095346, 2: -1.2232505839045147, 3: 0.54526025533510214},
}
B = {1: 0.24212380706095346, 2: -1.2232505839045147, 3: 1.5452602553351020, 4: 0.43586652150845900}
# of order 2
B_EMBEDDED = {1: 0.37810903145819369, 2: -0.096042292212423178, 3: 0.5, 4: 0.21793326075422950}
# y + h Σ_i (DENSE[i][0] θ + DENSE[i][1] θ² + DENSE[i][2] θ³) k_i
DENSE = {
    1: (1.0564298455794094, -1.3864882699759573, 0.5721822314575016),
    2: (2.296429974281067, -8.262611700275677, 4.742931142090097),
    3: (-1.307599564525376, 7.250979895056055, -4.398120075195578),
    4: (-1.045260255335102, 2.398120075195581, -0.9169932983520199),
}
# fmt: on
