"""Fingers as MPE notes for any synthesiser or DAW.

Rule: a pure core (`layouts`: places to pitches; `zone`: fingers to channels; `player`: frames to
messages) and thin input and output (`port`, `render`, `app`). It imports `halo_client` and
`halo_protocol`, never the service. `port` is also the MIDI output of `halo_drums`.
"""
