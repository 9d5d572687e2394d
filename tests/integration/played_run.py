"""What the tests of tumble watch look at: a source that is played, and a reader of server-sent events."""

import json
import urllib.request

from tumble.documents.watch import Gravity, Mean, Snapshot

K = ((-1.9959264, 0.0241898, 0.03929), (-0.0358031, -2.0022531, 0.0214949), (-0.0119907, 0.0242429, -1.9999533))
U_K = ((2.3e-5, 5.5e-5, 5.5e-5), (5.8e-5, 2.8e-5, 2.0e-5), (5.8e-5, 2.0e-5, 2.8e-5))
U0, U_U0 = (0.0116797, -0.0402083, 0.0616653), (1.7e-5, 2.4e-5, 2.4e-5)

AVERAGING = Snapshot(
    state="AVERAGE", run=3, mounting=1, position=4, count=18, finished=3, attempt=0, samples=34, wanted=50,
    stand="IN_POSITION", angle_rad=2.356194490192345, target_rad=2.356194490192345, temperature_c=24.5,
    mean=Mean(1, 4, 34, 50, (1.3719448, -0.0498841, -1.3609897), (5.1e-5, 4.9e-5, 4.7e-5)),
    gravity=Gravity(None, None, 3e-4, None), virtual_s=11.9,
)  # fmt: skip
FAULT = Snapshot(
    state="FAULT", reason="STALL", run=3, mounting=1, position=5, count=18, finished=4, attempt=0, stand="FAULT",
    gravity=Gravity(None, None, 3e-4, None), emergencies={"drive": "8611"}, over=True,
)  # fmt: skip
DONE = Snapshot(
    state="DONE", run=3, mounting=2, position=9, count=18, finished=18, attempt=0, stand="IN_POSITION", angle_rad=0.0,
    k_v_per_g=K, u0_v=U0, u_k_v_per_g=U_K, u_u0_v=U_U0, gravity=Gravity(5.79e-5, None, 3e-4, True), over=True,
)  # fmt: skip


class PlayedSource:
    """`answers`: what each question gets, an exception too; the last one again and again. `asked`: how many came."""

    def __init__(self, *answers):
        self.answers, self.asked, self.closed = list(answers), 0, False

    def snapshot(self):
        self.asked += 1
        answer = self.answers.pop(0) if len(self.answers) > 1 else self.answers[0]
        if isinstance(answer, Exception):
            raise answer
        return answer

    def close(self):
        self.closed = True


def events(url, timeout=20):
    """Yield (id, document) of a stream of server-sent events."""
    with urllib.request.urlopen(url, timeout=timeout) as stream:
        assert stream.headers["Content-Type"].startswith("text/event-stream")
        fields = {}
        for line in stream:
            name, _, value = line.decode().rstrip("\n").partition(": ")
            if name:
                fields[name] = value
            elif "data" in fields:
                yield int(fields["id"]), json.loads(fields["data"])
                fields = {}
