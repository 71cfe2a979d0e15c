/* The colours of a model's geoms. */
#include <math.h>
#include <string.h>

#include "vehicle/figures.h"

/* Turns a value of an sRGB file into an albedo. Black and white reflect some light, and not all. */
static float linear(float value)
{
	const double v = fmin(fmax((double)value, 0), 1), light = v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4);
	return (float)(0.01 + 0.6 * light);
}

void vehicle_paint(struct world_look *look, const float colour[3])
{
	for (int k = 0; k < 3; k++)
		look->colour[k] = linear(colour[k]);
	look->painted = true;
}

/* Gives the mean of a texture, 0 .. 1. Returns false if the material has none. */
static bool mean_of(const mjModel *model, int material, float mean[3])
{
	const int texture = model->mat_texid[mjNTEXROLE * material + mjTEXROLE_RGB];
	if (texture < 0)
		return false;
	const mjtSize pixels = (mjtSize)model->tex_width[texture] * model->tex_height[texture];
	const int channels = model->tex_nchannel[texture];
	const mjtByte *data = model->tex_data + model->tex_adr[texture];
	double sums[3] = {0, 0, 0};
	for (mjtSize i = 0; i < pixels; i++)
		for (int k = 0; k < 3; k++)
			sums[k] += data[i * channels + (channels >= 3 ? k : 0)];
	for (int k = 0; k < 3; k++)
		mean[k] = (float)(sums[k] / 255 / fmax((double)pixels, 1));
	return pixels > 0;
}

bool vehicle_has_pattern(const mjModel *model, int geom)
{
	const int material = model->geom_matid[geom];
	const int texture = material >= 0 ? model->mat_texid[mjNTEXROLE * material + mjTEXROLE_RGB] : -1;
	if (texture < 0)
		return false;
	const size_t channels = (size_t)model->tex_nchannel[texture], pixels = (size_t)model->tex_width[texture] * (size_t)model->tex_height[texture];
	const mjtByte *data = model->tex_data + model->tex_adr[texture];
	for (size_t i = 1; i < pixels; i++)
		if (memcmp(data + i * channels, data, channels) != 0)
			return true;
	return false;
}

/* MuJoCo's own grey: nobody chose it. */
static bool is_preset(const float rgba[4])
{
	static const float preset[4] = {0.5f, 0.5f, 0.5f, 1};
	return memcmp(rgba, preset, sizeof preset) == 0;
}

/* The colour of a geom: that of its material, if it has none of its own. */
static const float *rgba_of(const mjModel *model, int geom)
{
	const int material = model->geom_matid[geom];
	return material >= 0 && is_preset(&model->geom_rgba[4 * geom]) ? &model->mat_rgba[4 * material] : &model->geom_rgba[4 * geom];
}

float vehicle_alpha_of(const mjModel *model, int geom)
{
	return rgba_of(model, geom)[3];
}

void vehicle_look_of(const mjModel *model, int geom, struct world_look *look)
{
	const int material = model->geom_matid[geom];
	const float *rgba = rgba_of(model, geom);
	float colour[3], mean[3];
	const bool textured = material >= 0 && mean_of(model, material, mean);
	for (int k = 0; k < 3; k++)
		colour[k] = rgba[k] * (textured ? mean[k] : 1);
	if (material >= 0 || !is_preset(rgba))
		vehicle_paint(look, colour);
}
