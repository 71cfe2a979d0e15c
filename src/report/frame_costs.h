/* Made by bench/frame_costs.py from bench/figures/looks.json. Processor seconds of llvmpipe, all effects. */
static const struct frame_costs llvmpipe = {
	.pixel = 1.316e-07, /* s a pixel */
	.frame = 0.006313, /* s a frame */
	.sample = 0.2917, /* each sample above one, of a picture without */
	.terrain_shadow = 2.044, /* times a picture without */
	.error = 0.55, /* a pixel_error of 1, of a picture without */
	.error_power = 1.479, /* of 1 / pixel_error */
	.error_shaded = 2.303, /* times, with terrain_shadow */
	.relief = 2.823, /* the same over relief */
	.relief_power = 0.5677,
};
