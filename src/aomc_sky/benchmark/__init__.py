"""Speed against error: what each sampler costs, what accuracy it buys, and the bars that both must keep."""
