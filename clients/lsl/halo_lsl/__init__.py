"""Fingers as streams of the lab streaming layer (LSL), for recorders such as LabRecorder.

Rule: a pure core (`clock`: frame time to LSL's clock; `streams`: what each channel is; `samples`:
frames to samples) and thin output (`outlets`, `app`). It imports `halo_client` and
`halo_protocol`, never the service.
"""
