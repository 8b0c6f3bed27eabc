"""What the control page shows and does; `halo_service.web.control_page` serves it."""
