/* What furrow view draws over its picture, on the CPU: the line of figures, the legend of a layer, the keys. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "view.h"

#define MARGIN 8     /* pixels, times the scale */
#define LARGE 1400u  /* a picture wider than this has its letters twice as large */

static const struct render_colour white = {255, 255, 255, 255}, black = {0, 0, 0, 200}, shadow = {0, 0, 0, 150};

void view_figures_text(const struct viewer *viewer, const struct api_figures *figures, char *text, size_t size)
{
	char pace[24];
	if (viewer->pace == VIEW_PACE_MOST)
		snprintf(pace, sizeof pace, "free");
	else
		snprintf(pace, sizeof pace, "x%g", ldexp(1, viewer->pace));
	snprintf(text, size, "%.0f fps  %.1f ms  step %lld/%lld  %.2f s  %s  %.2f ms/step  slots %u/%u  hits %llu  misses %llu  dirty %zu  "
			     "queue %zu  %llu tri  eye %.1f %.1f %.1f",
		 figures->fps, figures->frame_ms, (long long)figures->step, (long long)figures->steps, figures->time,
		 figures->over ? "over" : viewer->paused ? "paused" : pace, figures->step_ms, figures->slots_used, figures->slots,
		 (unsigned long long)figures->hits, (unsigned long long)figures->misses, figures->dirty, figures->queued,
		 (unsigned long long)figures->triangles, viewer->eye.eye[0], viewer->eye.eye[1], viewer->eye.eye[2]);
}

/* On a dark band, so that it can be read over snow. */
static void write_line(const struct render_canvas *canvas, int x, int y, int scale, const char *text)
{
	int pad = 3 * scale;
	render_canvas_box(canvas, x - pad, y - pad, x + render_text_width(text, scale) + pad, y + scale * RENDER_LETTER_HEIGHT + pad, shadow);
	render_canvas_text(canvas, x, y, scale, text, white, (struct render_colour){0, 0, 0, 0});
}

/* In as many lines as the picture's width asks for, parted where figures are. */
static int draw_figures(const struct render_canvas *canvas, int scale, const char *text)
{
	char line[256];
	int letters = ((int)canvas->width - 2 * MARGIN * scale) / (RENDER_LETTER_WIDTH * scale), y = (int)canvas->height;
	while (*text != '\0') {
		int end = 0, length = snprintf(line, sizeof line, "%s", text);
		length = length < (int)sizeof line ? length : (int)sizeof line - 1;
		for (int i = 0; i <= length && i <= letters; i++)
			if (line[i] == '\0' || (line[i] == ' ' && line[i + 1] == ' '))
				end = i;
		end = end > 0 ? end : letters > 0 && letters < length ? letters : length;
		line[end] = '\0';
		y -= scale * (RENDER_LETTER_HEIGHT + 6);
		write_line(canvas, MARGIN * scale, y - 2 * scale, scale, line);
		text += end;
		while (*text == ' ')
			text++;
	}
	return y;
}

static void draw_help(const struct render_canvas *canvas, int scale, int top)
{
	int y = top - scale * RENDER_LETTER_HEIGHT;
	for (size_t i = 0; view_help(i) != NULL; i++) {
		y -= scale * (RENDER_LETTER_HEIGHT + 5);
		write_line(canvas, MARGIN * scale, y, scale, view_help(i));
	}
}

/* A bar of the layer's colours, with what its ends and its middle are. */
static void draw_legend(const struct render_canvas *canvas, int scale, const struct render_layer *layer)
{
	static const char *const units[RENDER_LAYERS] = {[RENDER_OFFSETS] = "m", [RENDER_DISTURBANCE] = "", [RENDER_HEIGHTS] = "m",
							 [RENDER_SLOPES] = "degrees"};
	int width = 200 * scale, height = 10 * scale, x = MARGIN * scale + 4, y = (MARGIN + 14) * scale;
	char text[64];
	if (units[layer->kind] == NULL || (int)canvas->width < width + 2 * x)
		return;
	render_canvas_box(canvas, x - 1, y - 1, x + width + 1, y + height + 1, black);
	for (int i = 0; i < width; i++)
		render_canvas_box(canvas, x + i, y, x + i + 1, y + height, render_layer_colour(layer->kind, (i + 0.5) / width));
	for (int i = 0; i < 3; i++) {
		snprintf(text, sizeof text, i == 2 ? "%.4g %s" : "%.4g", layer->low + (layer->high - layer->low) * i / 2, units[layer->kind]);
		int at = x + width * i / 2 - (i == 1 ? render_text_width(text, scale) / 2 : i == 2 ? RENDER_LETTER_WIDTH * scale : 0);
		render_canvas_text(canvas, at, y - 14 * scale, scale, text, white, black);
	}
}

void view_draw_over(const struct viewer *viewer, const struct api_figures *figures, uint8_t *pixels, uint32_t width, uint32_t height)
{
	const struct render_canvas canvas = {pixels, width, height};
	int scale = width > LARGE ? 2 : 1, top = (int)height;
	char text[320];
	if (viewer->line) {
		view_figures_text(viewer, figures, text, sizeof text - 96);
		if (viewer->told[0] != '\0')
			snprintf(text + strlen(text), sizeof text - strlen(text), "  %s", viewer->told);
		top = draw_figures(&canvas, scale, text);
	}
	if (viewer->layer != RENDER_NATURAL && viewer->line)
		draw_legend(&canvas, scale, &figures->layer);
	if (viewer->help)
		draw_help(&canvas, scale, top);
}
