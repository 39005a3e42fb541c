"""The standard deviation σ of the perturbations, ruled by successes and failures in a row."""


class StepSize:
    """σ is halved after `failure_tolerance` failures in a row and doubled after `success_tolerance` successes in a row.

    It never exceeds its start, and is exhausted when it has been halved more than `halvings` times on balance.
    Source: Regis and Shoemaker 2013.
    """

    def __init__(self, start: float, halvings: int, failure_tolerance: int, success_tolerance: int) -> None:
        self.sigma = start
        self._start = start
        self._least = start * 0.5**halvings
        self._tolerances = {True: success_tolerance, False: failure_tolerance}
        self._streak = (True, 0)

    @property
    def exhausted(self) -> bool:
        """Whether σ has fallen below the least value."""
        return self.sigma < self._least

    def record(self, success: bool) -> None:
        """Count a success or a failure and adapt σ when the streak is long enough."""
        kind, length = self._streak
        length = length + 1 if kind == success else 1
        if length == self._tolerances[success]:
            self.sigma = min(2.0 * self.sigma, self._start) if success else 0.5 * self.sigma
            length = 0
        self._streak = (success, length)
