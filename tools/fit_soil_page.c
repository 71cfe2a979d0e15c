/* furrow fit-soil's page: measured rows, fitted curves and residuals. It is one file that needs nothing beside it. */
#include "fit_soil.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "html_plot.h"
#include "svg.h"

enum { CURVE_POINTS = 80, DOTS_MOST = 1500 }; /* of a group */

struct series {
	double *x, *y;
	size_t count;
};

/* Curves of one test. */
struct page {
	const struct fit_soil *fit;
	const struct fit_table *table;
	enum fit_test test;
	FILE *file;
	struct html_line *lines;
	size_t count;
	double *numbers; /* what the lines point into */
	size_t used;
};

static double model(const struct page *page, double group, double x)
{
	const struct fit_soil *fit = page->fit;
	if (page->test == FIT_PENETRATION)
		return FIT_LEVEL_PLATE * fit->faces.strength.value * x;
	return page->test == FIT_PLATE ? fit_pressure(&fit->plates, fit->method, group, x) : fit_shear_stress(&fit->strength, group, x);
}

static int by_x(const void *a, const void *b)
{
	const struct fit_row *one = a, *other = b;
	return (one->x > other->x) - (one->x < other->x);
}

static struct series take(struct page *page, size_t count)
{
	struct series series = {page->numbers + page->used, page->numbers + page->used + count, count};
	page->used += 2 * count;
	return series;
}

static void add_line(struct page *page, const struct series *series, size_t colour, bool dots)
{
	page->lines[page->count++] = (struct html_line){.colour = colour, .count = series->count, .x = series->x, .y = series->y, .dots = dots};
}

/* The rows of a group, at most DOTS_MOST of them. Gaps between them, so that there are dots and no line. x: mm, y: kPa. */
static enum status add_dots(struct page *page, size_t group, bool residuals)
{
	struct fit_row *rows = mem_alloc(page->table->count, sizeof *rows);
	size_t count = 0;
	TRY_MEM(rows, "a page");
	for (size_t i = 0; i < page->table->count; i++)
		if (fit_table_group(page->table, &page->table->rows[i]) == group)
			rows[count++] = page->table->rows[i];
	qsort(rows, count, sizeof *rows, by_x);
	const size_t every = count / DOTS_MOST + 1;
	const struct series series = take(page, 2 * ((count + every - 1) / every));
	for (size_t i = 0; i < count; i += every) {
		const struct fit_row *row = &rows[i];
		const double y = residuals ? row->y - model(page, row->group, row->x) : row->y;
		double *x = &series.x[2 * (i / every)], *to = &series.y[2 * (i / every)];
		x[0] = x[1] = row->x * 1e3;
		to[0] = y * 1e-3;
		to[1] = (double)NAN;
	}
	add_line(page, &series, group, true);
	mem_free(rows);
	return STATUS_OK;
}

static void add_curve(struct page *page, size_t group, double most)
{
	const struct series series = take(page, CURVE_POINTS);
	for (size_t i = 0; i < CURVE_POINTS; i++) {
		const double x = most * (double)i / (CURVE_POINTS - 1);
		series.x[i] = x * 1e3;
		series.y[i] = model(page, page->table->groups[group], x) * 1e-3;
	}
	add_line(page, &series, group, false);
}

static enum status write_plot(struct page *page, bool residuals)
{
	static const struct {
		const char *title, *residuals, *across, *up;
	} words[] = {[FIT_PLATE] = {"pressure over sinkage", "residuals of pressure", "sinkage, mm", "pressure, kPa"},
		     [FIT_SHEAR] = {"shear stress over displacement", "residuals of shear stress", "displacement, mm", "shear stress, kPa"},
		     [FIT_PENETRATION] = {"pressure over depth", "residuals of pressure over depth", "depth, mm", "pressure, kPa"}};
	const struct html_plot plot = {
		.title = residuals ? words[page->test].residuals : words[page->test].title,
		.across = words[page->test].across,
		.up = residuals ? "measured - fitted, kPa" : words[page->test].up,
		.zero = true,
		.upright = (double)NAN,
	};
	double most = 0;
	page->count = page->used = 0;
	for (size_t i = 0; i < page->table->count; i++)
		most = fmax(most, page->table->rows[i].x);
	for (size_t g = 0; g < page->table->group_count; g++) {
		TRY(add_dots(page, g, residuals));
		if (!residuals)
			add_curve(page, g, most);
	}
	struct html_plot filled = plot;
	filled.lines = page->lines;
	filled.count = page->count;
	fputs("<figure>", page->file);
	html_plot_write(&filled, page->file);
	fputs("</figure>\n", page->file);
	return STATUS_OK;
}

static void write_legend(const struct page *page)
{
	FILE *file = page->file;
	fputs("<ul class=\"legend\">\n", file);
	for (size_t g = 0; g < page->table->group_count; g++) {
		fprintf(file, "<li><svg class=\"key\" viewBox=\"0 0 34 10\"><path class=\"curve s%zu\" d=\"M1 5h32\"/><circle class=\"f%zu\" cx=\"17\" cy=\"5\" r=\"2.5\"/></svg> ",
			g % HTML_COLOURS, g % HTML_COLOURS);
		if (page->test == FIT_PLATE)
			fprintf(file, "plate of %g mm</li>\n", page->table->groups[g] * 1e3);
		else if (page->test == FIT_PENETRATION && !(page->table->groups[g] > 0))
			fputs("penetration</li>\n", file);
		else if (page->test == FIT_PENETRATION)
			fprintf(file, "plate of %g cm2</li>\n", page->table->groups[g] * 1e4);
		else
			fprintf(file, "normal stress %g kPa</li>\n", page->table->groups[g] * 1e-3);
	}
	fputs("</ul>\n<p class=\"small\">Dots: measured. Lines: fitted.</p>\n", file);
}

static void write_row(FILE *file, const char *name, struct fit_number number, double scale, const char *unit)
{
	char error[32];
	fprintf(file, "<tr><th>%s</th><td class=\"number\">%.5g</td><td class=\"number\">", name, number.value * scale);
	if (isfinite(number.error))
		fputs(fit_soil_error(number.error * scale, error), file);
	else
		fputs("<span class=\"none\">not fitted</span>", file);
	fprintf(file, "</td><td>%s</td></tr>\n", unit);
}

static void write_quality(FILE *file, const struct fit_quality *quality)
{
	fprintf(file, "</tbody></table></div>\n<p>%zu rows. Residuals: rms %.4g kPa, largest %.4g kPa in line %d. Goodness of fit: %.3f.</p>\n", quality->rows,
		quality->rms * 1e-3, quality->largest * 1e-3, quality->largest_line, quality->goodness);
}

static void table_head(FILE *file)
{
	fputs("<div class=\"scroll\"><table><thead><tr><th>number</th><th>value</th><th>standard error</th><th>unit</th></tr></thead><tbody>\n", file);
}

static void write_plates_table(const struct page *page)
{
	const struct fit_plates *plates = &page->fit->plates;
	const enum fit_method method = page->fit->method;
	table_head(page->file);
	write_row(page->file, "kc", plates->kc[method], 1, "N/m^(n+1)");
	write_row(page->file, "kphi", plates->kphi[method], 1, "N/m^(n+2)");
	write_row(page->file, "n", plates->n[method], 1, "");
	write_quality(page->file, &plates->quality[method]);
	if (plates->one_width)
		fputs("<p>One width does not tell kc and kphi apart. kphi is their sum for that width.</p>\n", page->file);
}

static void write_shear_table(const struct page *page)
{
	const struct fit_shear *shear = &page->fit->strength;
	table_head(page->file);
	write_row(page->file, "cohesion", shear->cohesion, 1, "Pa");
	write_row(page->file, "friction angle", shear->friction, 180 / M_PI, "degrees");
	write_row(page->file, "Janosi's K", shear->shear, 1, "m");
	write_quality(page->file, &shear->quality);
	if (shear->one_stress)
		fputs("<p>One normal stress does not tell cohesion and friction apart. One of them is taken for 0.</p>\n", page->file);
}

static void write_penetration_table(const struct page *page)
{
	const struct fit_penetration *faces = &page->fit->faces;
	table_head(page->file);
	write_row(page->file, "face strength", faces->strength, 1, "N/m3");
	write_row(page->file, "with an offset", faces->slope, 1, "N/m3");
	write_row(page->file, "the offset", faces->offset, 1, "Pa");
	write_quality(page->file, &faces->quality);
}

static enum status write_test(const struct fit_soil *fit, enum fit_test test, FILE *file)
{
	const struct fit_table *const tables[] = {[FIT_PLATE] = &fit->plate, [FIT_SHEAR] = &fit->shear, [FIT_PENETRATION] = &fit->penetration};
	static const char *const ids[] = {[FIT_PLATE] = "plates", [FIT_SHEAR] = "shear", [FIT_PENETRATION] = "penetration"};
	static void (*const write_tables[])(const struct page *) = {write_plates_table, write_shear_table, write_penetration_table}; /* by enum fit_test */
	struct page page = {.fit = fit, .table = tables[test], .test = test, .file = file};
	const size_t groups = page.table->group_count;
	page.lines = mem_alloc(2 * groups, sizeof *page.lines);
	page.numbers = mem_alloc(4 * (page.table->count + groups) + 2 * CURVE_POINTS * groups, sizeof *page.numbers);
	enum status status;
	TRY_OR(done, page.lines != NULL && page.numbers != NULL ? STATUS_OK : fail_memory("a page"));
	fprintf(file, "<section id=\"%s\"><h2>", ids[test]);
	svg_text(page.table->path, file);
	fputs("</h2>\n", file);
	write_tables[test](&page);
	fputs("<div class=\"plots\">\n", file);
	TRY_OR(done, write_plot(&page, false));
	TRY_OR(done, write_plot(&page, true));
	fputs("</div>\n", file);
	write_legend(&page);
	fputs("</section>\n", file);
done:
	mem_free_all(page.lines, page.numbers);
	return status;
}

/* The soil as a scene takes it. */
static enum status write_soil(const struct fit_soil *fit, FILE *file)
{
	char *text = NULL;
	size_t size = 0;
	FILE *memory = open_memstream(&text, &size);
	TRY_MEM(memory, "a page");
	fit_soil_block(fit, memory);
	const bool whole = fclose(memory) == 0;
	fputs("<section id=\"soil\"><h2>soil of a scene</h2>\n<pre>", file);
	for (char *line = text, *end; whole && *line != '\0'; line = end + 1) {
		end = line + strcspn(line, "\n");
		const bool last = *end == '\0';
		*end = '\0';
		svg_text(line, file);
		fputc('\n', file);
		if (last)
			break;
	}
	fputs("</pre></section>\n", file);
	free(text);
	return whole ? STATUS_OK : fail_memory("a page");
}

enum status fit_soil_page(const struct fit_soil *fit, FILE *file)
{
	fprintf(file, "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"/><meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n"
		      "<title>furrow fit-soil</title>\n<style>\n%spre{overflow-x:auto}</style></head><body>\n<h1>A soil from its tests</h1>\n"
		      "<p class=\"small\">Told by furrow fit-soil " FURROW_VERSION ", method %s</p>\n", html_style, fit_soil_methods[fit->method]);
	if (fit->has_plate)
		TRY(write_test(fit, FIT_PLATE, file));
	if (fit->has_shear)
		TRY(write_test(fit, FIT_SHEAR, file));
	if (fit->has_penetration)
		TRY(write_test(fit, FIT_PENETRATION, file));
	TRY(write_soil(fit, file));
	fputs("</body></html>\n", file);
	return STATUS_OK;
}
