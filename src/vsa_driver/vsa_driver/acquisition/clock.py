"""Capture time of a frame on the epoch, whatever clock the adapter stamps with."""

import math

NANOSECONDS = 1_000_000_000

_ON_EPOCH_NS = 60 * NANOSECONDS  # stamps this near to the host's time are of its clock
_LATEST_S = 2.0**34  # no clock shows the year 2514
_DRIFT = 2e-4  # an adapter's crystal may be this much slower than the host's


class CaptureClock:
    """Maps an adapter's time stamps to the epoch.

    Stamps of the host's clock (socketcan, udp_multicast) pass unchanged. An adapter that counts from its own start
    is mapped by the least delay seen between its stamp and the arrival; that follows its drift and its restarts, and
    no stamp lies in the future. An adapter without stamps (0) gets the time of arrival.
    """

    def __init__(self) -> None:
        self.restarts = 0  # of the adapter's clock
        self._device_ns: int | None = None
        self._offset_ns = math.inf  # steady clock minus adapter's clock, at the least delay

    def epoch(self, timestamp: float, now_ns: int, steady_ns: int) -> int:
        """Stamp [ns since the epoch] of a frame stamped `timestamp` [s] that arrived at `now_ns`.

        `steady_ns` is the arrival on a clock that is never set.
        """
        if not 0.0 < timestamp < _LATEST_S:  # also false for NaN
            return now_ns
        seconds = int(timestamp)
        device_ns = seconds * NANOSECONDS + round((timestamp - seconds) * NANOSECONDS)
        if abs(now_ns - device_ns) < _ON_EPOCH_NS:
            return device_ns
        return now_ns - steady_ns + self._steady(device_ns, steady_ns)

    def _steady(self, device_ns: int, steady_ns: int) -> int:
        if self._device_ns is not None:
            if device_ns < self._device_ns:
                self.restarts += 1
                self._offset_ns = math.inf
            else:
                self._offset_ns += _DRIFT * (device_ns - self._device_ns)
        self._device_ns = device_ns
        self._offset_ns = min(self._offset_ns, steady_ns - device_ns)
        return device_ns + int(self._offset_ns)
