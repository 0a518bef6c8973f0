"""For authors of drivers: the controller to test against, its servers, and faults on purpose."""
