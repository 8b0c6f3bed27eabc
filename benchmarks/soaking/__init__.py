"""A whole service with faults, for `benchmarks/soak.py`.

`service.py`: service and router, in processes of their own. `client.py`: what a client counts.
`running.py`: starts, ends and watches them. `faults.py`: faults of camera, tracker and clock.
`observer.py`: waits for what a fault does. `around.py`: faults around the service. `evening.py`:
one fault after the other. `figures.py`, `result.py`: what was seen, and whether that is good.
"""
