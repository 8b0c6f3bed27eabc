"""The bench's results as one page that one can show: figures beside the paper's, and its plots."""
