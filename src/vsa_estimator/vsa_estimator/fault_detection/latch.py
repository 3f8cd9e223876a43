"""Complaints about the sensors: stuck, saturated, noisy, or told by the gate too often."""

from vsa_estimator.preprocessing import sensor_checks as signs

COMPLAINT_TIME = 0.5  # a complaint stands for this long after its cause [s] ...
LAST_NS = (1 << 63) - 1  # ... and never beyond the last stamp that there is [ns]

FAULT_TEXTS = {
    signs.FORCE_NOISY: "force sensor noisy: several times what was configured",
    signs.ENCODER_NOISY: "encoder noisy: several times what was configured",
    signs.BURST: "samples in a burst: they queued up on their way",
    signs.ENCODER_FROZEN: "encoder stuck: it repeats itself to the last digit",
    signs.FORCE_STUCK: "force sensor stuck: it repeats itself while the encoder moves",
    signs.ENCODER_STUCK: "encoder stuck: it repeats itself while the force changes",
    signs.FORCE_SATURATED: "force sensor saturated",
    signs.DEFLECTION_SATURATED: "deflection at its limit",
}


class FaultLatch:
    """What the signs in the raw samples of late say of the sensors."""

    def __init__(self) -> None:
        """All is well."""
        self.force_repeated = 0
        self.clear()

    def clear(self) -> None:
        """Forget the past: stamps went back."""
        self._complaints: dict[str, int] = {}

    def add_flags(self, found: int, stamp_ns: int) -> None:
        """Take the signs of a raw sample."""
        self.force_repeated += found & signs.FORCE_REPEATED
        for sign, complaint in FAULT_TEXTS.items():
            if found & sign:
                self.raise_fault(complaint, stamp_ns)

    def raise_fault(self, text: str, stamp_ns: int) -> None:
        """Say `text` from now on for a while."""
        self._complaints[text] = min(stamp_ns + int(COMPLAINT_TIME * 1e9), LAST_NS)

    @property
    def until_ns(self) -> int:
        """Until when a complaint stands; 0 where none ever did."""
        return max(self._complaints.values(), default=0)

    def active_faults(self, stamp_ns: int) -> list[str]:
        """Complaints that stand at an instant."""
        return [text for text, until_ns in self._complaints.items() if stamp_ns < until_ns]
