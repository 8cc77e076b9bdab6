"""Problems from the literature: our results against second solutions, and both against published values."""

from decimal import Decimal

import pytest

from chain_impact.scene.files.models import model_names
from tests.helpers.literature import coulomb_literature, stored
from tests.helpers.literature.asked_elsewhere import QUESTIONS
from tests.helpers.literature.validation import PROBLEMS

TIGHT = 1e-12


@pytest.fixture(scope="module", params=PROBLEMS)
def problem(request):
    return PROBLEMS[request.param](TIGHT)


@pytest.mark.full("more cases", but="double_pendulum_wall")
def test_every_problem_is_a_model_or_a_scene_of_the_tests(problem):
    name = problem.model
    assert name in model_names() or hasattr(coulomb_literature, name) or hasattr(stored, name)
    assert len(problem.figures) >= 2


@pytest.mark.full("more cases", but=["double_pendulum_wall", "simple_pendulum"])
def test_our_result_is_that_of_the_second_solution(problem):
    for figure in problem.figures:
        assert figure.ours == pytest.approx(figure.independent, rel=0, abs=figure.held), figure.quantity


@pytest.mark.full("more cases", but=["double_pendulum_wall", "simple_pendulum"])
def test_published_figures_differ_as_documented(problem):
    for figure in problem.figures:
        if figure.published is None:
            continue
        off = abs(float(figure.published) - figure.independent)
        assert off <= figure.published_error, figure.quantity
        if figure.measured:  # the difference comes from neglected effects and errors of the measurement
            assert not figure.inaccurate
            continue
        # a published figure with the note "inaccurate" has an error above its last digit, and above our
        # result's error
        last_digit = 10.0 ** Decimal(figure.published).as_tuple().exponent
        own_error = abs(figure.ours - figure.independent)
        assert figure.inaccurate == (off > 1.01 * last_digit and off > 10 * own_error), figure.quantity


@pytest.mark.parametrize("question", QUESTIONS, ids=lambda question: question.threads[0])
def test_questions_from_elsewhere_have_their_closed_forms(question):
    assert question.ours() == pytest.approx(question.exact, rel=question.held, abs=question.held)
