/* What furrow fit-soil found: as text, as a scene's soil, as JSON. */
#include "fit_soil.h"

#include <math.h>

#include "json.h"

#define DEGREES (180 / M_PI)
#define OFFSET_TOLD 3 /* standard errors */

const char *fit_soil_error(double error, char text[32])
{
	const double digit = error > 0 ? pow(10, floor(log10(error)) - 1) : 1;
	const bool plain = error >= 100 && error < 1e7;
	snprintf(text, 32, plain ? "%.0f" : "%.2g", plain ? round(error / digit) * digit : error);
	return text;
}

/* --- text --- */

static void print_number(struct fit_number number, double scale)
{
	char text[64], error[32];
	if (isfinite(number.error))
		snprintf(text, sizeof text, "%.5g +- %s", number.value * scale, fit_soil_error(number.error * scale, error));
	else
		snprintf(text, sizeof text, "%.5g", number.value * scale);
	printf("%24s", text);
}

static void print_quality(const struct fit_quality *quality, const char *before)
{
	printf("%sresiduals: rms %.4g Pa, largest %.4g Pa in line %d; goodness of fit %.3f\n", before, quality->rms, quality->largest, quality->largest_line,
	       quality->goodness);
}

static void print_head(const struct fit_table *table, const char *what, double scale, const char *unit)
{
	printf("%s: %zu rows, %s", table->path, table->count, what);
	for (size_t g = 0; g < table->group_count && unit[0] != '\0'; g++)
		printf("%s %g", g > 0 ? "," : "", table->groups[g] * scale);
	printf("%s%s", unit[0] != '\0' ? " " : "", unit);
	if (table->skipped > 0)
		printf("; %zu at 0 left out", table->skipped);
	putchar('\n');
}

static void print_plates(const struct fit_soil *fit)
{
	const struct fit_plates *plates = &fit->plates;
	const struct {
		const char *name;
		const struct fit_number *numbers;
	} rows[] = {{"kc, N/m^(n+1)", plates->kc}, {"kphi, N/m^(n+2)", plates->kphi}, {"n", plates->n}};
	print_head(&fit->plate, "plates of", 1e3, "mm");
	printf("  %-16s%24s%24s\n", "", "plain", "weighted as Wong");
	for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
		printf("  %-16s", rows[i].name);
		for (int method = 0; method < FIT_METHODS; method++)
			print_number(rows[i].numbers[method], 1);
		putchar('\n');
	}
	for (int method = 0; method < FIT_METHODS; method++)
		print_quality(&plates->quality[method], method == FIT_PLAIN ? "  plain: " : "  Wong:  ");
	for (size_t g = 0; g < fit->plate.group_count; g++)
		printf("  the plate of %g mm alone, as Wong: p = %.4g z^%.4g; goodness of fit %.3f\n", fit->plate.groups[g] * 1e3, plates->curves[g].k,
		       plates->curves[g].n, plates->curves[g].quality.goodness);
	if (plates->one_width)
		printf("  One width does not tell kc and kphi apart. kc is 0, and kphi is k = kc / b + kphi for b = %g mm.\n", fit->plate.groups[0] * 1e3);
	const double kc = plates->kc[fit->method].value, kphi = plates->kphi[fit->method].value;
	if (kc < 0)
		printf("  kc is below 0. So k = kc / b + kphi is above 0 only for widths over %.3g mm.\n", -kc / kphi * 1e3);
	if (plates->no_kphi)
		puts("  kphi came out below 0, which no scene takes. It is 0, and the others were fitted with it.");
}

static void print_shear(const struct fit_soil *fit)
{
	const struct fit_shear *shear = &fit->strength;
	print_head(&fit->shear, "normal stresses of", 1e-3, "kPa");
	printf("  %-16s", "cohesion, Pa");
	print_number(shear->cohesion, 1);
	printf("\n  %-16s", "friction, deg");
	print_number(shear->friction, DEGREES);
	printf("\n  %-16s", "Janosi's K, m");
	print_number(shear->shear, 1);
	putchar('\n');
	print_quality(&shear->quality, "  ");
	if (shear->one_stress)
		printf("  One normal stress does not tell cohesion and friction apart. The %s is taken for 0.\n",
		       isfinite(shear->friction.error) ? "cohesion" : "friction");
	if (shear->no_cohesion || shear->no_friction)
		printf("  The %s came out below 0, which no scene takes. It is 0, and the others were fitted with it.\n",
		       shear->no_cohesion ? "cohesion" : "friction");
}

static void print_penetration(const struct fit_soil *fit)
{
	const struct fit_penetration *faces = &fit->faces;
	const struct fit_table *table = &fit->penetration;
	char error[32];
	const bool areas = table->groups[0] > 0;
	print_head(table, areas ? "plates of" : "pressures", 1e4, areas ? "cm2" : "");
	printf("  %-16s", "faces, N/m3");
	print_number(faces->strength, 1);
	putchar('\n');
	print_quality(&faces->quality, "  ");
	for (size_t g = 0; g < table->group_count && table->group_count > 1; g++)
		printf("  the plate of %g cm2 alone: %.5g N/m3\n", table->groups[g] * 1e4, faces->alone[g].value);
	if (!(faces->offset.error > 0))
		return;
	printf("  with an offset: %.5g +- %s N/m3, and ", faces->slope.value, fit_soil_error(faces->slope.error, error));
	printf("%.4g +- %s Pa at the surface\n", faces->offset.value, fit_soil_error(faces->offset.error, error));
	if (fabs(faces->offset.value) > OFFSET_TOLD * faces->offset.error)
		puts("  The offset is more than its error: the pressure is not in proportion to depth, as it is in dry soil without cohesion. Look at the residuals.");
}

void fit_soil_print(const struct fit_soil *fit)
{
	if (fit->has_plate)
		print_plates(fit);
	if (fit->has_shear)
		print_shear(fit);
	if (fit->has_penetration)
		print_penetration(fit);
}

/* --- a scene's soil --- */

static void write_name(const char *text, FILE *file)
{
	for (; *text != '\0'; text++)
		fputc((unsigned char)*text < ' ' || *text == 0x7f ? '?' : *text, file);
}

static void write_key(const char *key, struct fit_number number, double scale, const char *unit, FILE *file)
{
	char error[32];
	fprintf(file, "  %s: %.12g  # %s", key, number.value * scale, unit);
	if (isfinite(number.error))
		fprintf(file, "%s+- %s", unit[0] != '\0' ? ", " : "", fit_soil_error(number.error * scale, error));
	else
		fprintf(file, "%snot fitted", unit[0] != '\0' ? ", " : "");
	fputc('\n', file);
}

void fit_soil_block(const struct fit_soil *fit, FILE *file)
{
	const struct fit_plates *plates = &fit->plates;
	const struct fit_shear *shear = &fit->strength;
	const enum fit_method method = fit->method;
	const char *const paths[] = {fit->has_plate ? fit->plate.path : NULL, fit->has_shear ? fit->shear.path : NULL,
				     fit->has_penetration ? fit->penetration.path : NULL};
	const char *before = "# furrow fit-soil " FURROW_VERSION ", ";
	for (size_t i = 0; i < sizeof paths / sizeof *paths; i++) {
		if (paths[i] == NULL)
			continue;
		fputs(before, file);
		write_name(paths[i], file);
		before = " and ";
	}
	if (fit->has_plate)
		fprintf(file, ", method %s", fit_soil_methods[method]);
	fprintf(file, ". Behind +-: standard errors\nsoil:\n  name: %s  # what was not measured is that soil's\n", fit->named);
	if (fit->has_plate) {
		write_key("bekker_kc", plates->kc[method], 1, "N/m^(n+1)", file);
		write_key("bekker_kphi", plates->kphi[method], 1, "N/m^(n+2)", file);
		write_key("bekker_n", plates->n[method], 1, "", file);
	}
	if (fit->has_shear) {
		write_key("cohesion", shear->cohesion, 1, "Pa", file);
		write_key("friction_angle", shear->friction, DEGREES, "degrees", file);
		write_key("janosi_shear", shear->shear, 1, "m", file);
		if (shear->friction.value > 0)
			fprintf(file, "  repose: %.12g  # degrees: the friction angle\n", shear->friction.value * DEGREES);
	}
	if (fit->has_penetration)
		write_key("face_strength", fit->faces.strength, 1, "N/m3", file);
}

/* --- JSON --- */

static void add_number(cJSON *object, const char *name, struct fit_number number, double scale)
{
	cJSON *to = cJSON_AddObjectToObject(object, name);
	cJSON_AddNumberToObject(to, "value", number.value * scale);
	json_number(to, "error", number.error * scale);
}

static void add_quality(cJSON *object, const struct fit_quality *quality)
{
	cJSON_AddNumberToObject(object, "rms", quality->rms);
	cJSON_AddNumberToObject(object, "largest", quality->largest);
	cJSON_AddNumberToObject(object, "largest_line", quality->largest_line);
	json_number(object, "goodness", quality->goodness);
}

static cJSON *add_table(cJSON *root, const char *name, const struct fit_table *table, const char *groups)
{
	cJSON *object = cJSON_AddObjectToObject(root, name);
	cJSON_AddStringToObject(object, "file", table->path);
	cJSON_AddNumberToObject(object, "rows", (double)table->count);
	cJSON_AddNumberToObject(object, "skipped", (double)table->skipped);
	cJSON *list = cJSON_AddArrayToObject(object, groups);
	for (size_t g = 0; g < table->group_count; g++)
		cJSON_AddItemToArray(list, cJSON_CreateNumber(table->groups[g]));
	return object;
}

static void add_plates(cJSON *root, const struct fit_soil *fit)
{
	const struct fit_plates *plates = &fit->plates;
	cJSON *object = add_table(root, "plate", &fit->plate, "widths");
	cJSON_AddBoolToObject(object, "one_width", plates->one_width);
	cJSON_AddBoolToObject(object, "no_kphi", plates->no_kphi);
	for (int method = 0; method < FIT_METHODS; method++) {
		cJSON *to = cJSON_AddObjectToObject(object, fit_soil_methods[method]);
		add_number(to, "kc", plates->kc[method], 1);
		add_number(to, "kphi", plates->kphi[method], 1);
		add_number(to, "n", plates->n[method], 1);
		add_quality(to, &plates->quality[method]);
	}
	cJSON *curves = cJSON_AddArrayToObject(object, "curves");
	for (size_t g = 0; g < fit->plate.group_count; g++) {
		cJSON *curve = cJSON_CreateObject();
		cJSON_AddItemToArray(curves, curve);
		cJSON_AddNumberToObject(curve, "width", fit->plate.groups[g]);
		cJSON_AddNumberToObject(curve, "k", plates->curves[g].k);
		cJSON_AddNumberToObject(curve, "n", plates->curves[g].n);
		add_quality(curve, &plates->curves[g].quality);
	}
}

static void add_shear(cJSON *root, const struct fit_soil *fit)
{
	const struct fit_shear *shear = &fit->strength;
	cJSON *object = add_table(root, "shear", &fit->shear, "normal_stresses");
	cJSON_AddBoolToObject(object, "one_stress", shear->one_stress);
	cJSON_AddBoolToObject(object, "no_cohesion", shear->no_cohesion);
	cJSON_AddBoolToObject(object, "no_friction", shear->no_friction);
	add_number(object, "cohesion", shear->cohesion, 1);
	add_number(object, "friction_angle", shear->friction, DEGREES);
	add_number(object, "janosi_shear", shear->shear, 1);
	add_quality(object, &shear->quality);
}

static void add_penetration(cJSON *root, const struct fit_soil *fit)
{
	const struct fit_penetration *faces = &fit->faces;
	cJSON *object = add_table(root, "penetration", &fit->penetration, "areas");
	add_number(object, "face_strength", faces->strength, 1);
	add_quality(object, &faces->quality);
	cJSON *offset = cJSON_AddObjectToObject(object, "with_offset");
	add_number(offset, "face_strength", faces->slope, 1);
	add_number(offset, "offset", faces->offset, 1);
	cJSON *alone = cJSON_AddArrayToObject(object, "alone");
	for (size_t g = 0; g < fit->penetration.group_count; g++)
		cJSON_AddItemToArray(alone, cJSON_CreateNumber(faces->alone[g].value));
}

enum status fit_soil_json(const struct fit_soil *fit)
{
	cJSON *root = cJSON_CreateObject(), *soil = cJSON_CreateObject();
	const enum fit_method method = fit->method;
	cJSON_AddItemToObject(root, "soil", soil);
	cJSON_AddStringToObject(soil, "name", fit->named);
	if (fit->has_plate) {
		cJSON_AddNumberToObject(soil, "bekker_kc", fit->plates.kc[method].value);
		cJSON_AddNumberToObject(soil, "bekker_kphi", fit->plates.kphi[method].value);
		cJSON_AddNumberToObject(soil, "bekker_n", fit->plates.n[method].value);
	}
	if (fit->has_shear) {
		cJSON_AddNumberToObject(soil, "cohesion", fit->strength.cohesion.value);
		cJSON_AddNumberToObject(soil, "friction_angle", fit->strength.friction.value * DEGREES);
		cJSON_AddNumberToObject(soil, "janosi_shear", fit->strength.shear.value);
	}
	if (fit->has_penetration)
		cJSON_AddNumberToObject(soil, "face_strength", fit->faces.strength.value);
	cJSON_AddStringToObject(root, "method", fit_soil_methods[method]);
	if (fit->has_plate)
		add_plates(root, fit);
	if (fit->has_shear)
		add_shear(root, fit);
	if (fit->has_penetration)
		add_penetration(root, fit);
	return json_print(root);
}
