"""What joins the model and the widgets: jobs, files, filters, display."""
