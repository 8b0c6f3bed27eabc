"""A hundred nodes at one router: publishers, router and subscribers in processes of their own."""
