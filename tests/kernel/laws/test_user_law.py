"""What stands in the place of a user's law in a kernel that has none."""

from chain_impact.kernel.laws.user_law import ARGUMENTS, force, present


def test_a_kernel_has_no_law_of_the_users_until_one_is_linked_in():
    assert present() == 0
    assert force(*[1.0] * len(ARGUMENTS)) == 0.0
