#include "html_report.h"

#include <string.h>

#include "svg.h"

/* Paper and light screens; dark screens. Colours of curves: Okabe's and Ito's, lighter on dark ground. */
const char html_style[] =
	":root{--ground:#fff;--text:#1c1c1c;--soft:#5a5a5a;--line:#ddd;--zero:#888;--head:#f3f3f1;"
	"--c0:#0072b2;--c1:#c24e00;--c2:#00805d;--c3:#b4548c;--c4:#946300;--c5:#6a3fb5;--c6:#111;--c7:#666}\n"
	"@media screen and (prefers-color-scheme:dark){:root{--ground:#141414;--text:#e4e4e4;--soft:#a6a6a6;--line:#333;--zero:#888;--head:#222;"
	"--c0:#56b4e9;--c1:#f0883e;--c2:#35c79a;--c3:#e39ac4;--c4:#e6b422;--c5:#b39df3;--c6:#f2f2f2;--c7:#aaa}}\n"
	"html{color-scheme:light dark}body{font:15px/1.45 system-ui,sans-serif;margin:0 auto;padding:1rem;max-width:75rem;background:var(--ground);color:var(--text)}\n"
	"h1{font-size:1.5rem;margin:.5rem 0;overflow-wrap:anywhere}h2{font-size:1.15rem;margin:2rem 0 .6rem;border-bottom:1px solid var(--line)}\n"
	".small,small,figcaption{font-size:.85rem;color:var(--soft)}p{margin:.5rem 0;overflow-wrap:anywhere}\n"
	".scroll{overflow-x:auto}table{border-collapse:collapse;font-size:.9rem}th,td{padding:.2rem .7rem;border-bottom:1px solid var(--line);text-align:left;vertical-align:top}\n"
	"td{overflow-wrap:anywhere;min-width:5rem}.place{min-width:11rem}thead th{background:var(--head)}tbody th{font-weight:normal;color:var(--soft);min-width:8rem}.number{font-variant-numeric:tabular-nums}.none{color:var(--soft)}\n"
	".plots{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,26rem),1fr));gap:1rem}.plots>p{grid-column:1/-1}.wide{grid-template-columns:minmax(0,44rem)}\n"
	"figure{margin:0}img{max-width:100%;height:auto;background:#fff}svg{width:100%;height:auto;display:block}svg text{font:12px system-ui,sans-serif;fill:var(--text)}svg .name{font-weight:600}.thumbs{display:flex;flex-wrap:wrap;gap:.5rem 1rem}.thumbs img{display:block}\n"
	".grid{stroke:var(--line);fill:none}.zero{stroke:var(--zero);fill:none}.mark{stroke:var(--soft);stroke-dasharray:5 4;fill:none}.halo{stroke:var(--ground);stroke-opacity:.75;stroke-width:4;fill:none;stroke-linejoin:round}.edge{stroke:var(--zero);fill:none}.begin{stroke:var(--ground);stroke-width:1.2}.map .grid,.map .zero{stroke:#000;stroke-opacity:.15}.ramp{max-width:22rem}.curve{fill:none;stroke-width:1.6;stroke-linejoin:round}.area{opacity:.16;stroke:none}\n"
	".s0{stroke:var(--c0)}.s1{stroke:var(--c1)}.s2{stroke:var(--c2)}.s3{stroke:var(--c3)}.s4{stroke:var(--c4)}.s5{stroke:var(--c5)}.s6{stroke:var(--c6)}.s7{stroke:var(--c7)}\n"
	".f0{fill:var(--c0)}.f1{fill:var(--c1)}.f2{fill:var(--c2)}.f3{fill:var(--c3)}.f4{fill:var(--c4)}.f5{fill:var(--c5)}.f6{fill:var(--c6)}.f7{fill:var(--c7)}\n"
	".legend{list-style:none;margin:.4rem 0;padding:0;display:flex;flex-wrap:wrap;gap:.1rem 1.2rem;font-size:.9rem}.key{display:inline-block;width:34px;height:10px}\n"
	".map .s7{stroke:#444}.map .f7{fill:#444}summary{cursor:pointer}\n"
	"@media print{body{max-width:none;padding:0;font-size:11px}.scroll{overflow:visible}table{font-size:.8rem}td,.place{min-width:0}th,td{padding:.15rem .4rem}tbody th{min-width:0}section{break-inside:auto}h2{break-after:avoid}svg,figure,tr,.legend{break-inside:avoid}.plots{grid-template-columns:1fr 1fr}.wide{grid-template-columns:minmax(0,26rem)}.legend,h2+p{break-after:avoid}"
	"*{print-color-adjust:exact;-webkit-print-color-adjust:exact}}\n";

void html_section(const struct html_report *report, const char *id, const char *title)
{
	fprintf(report->file, "<section id=\"%s\"><h2>%s</h2>\n", id, title);
}

void html_section_end(const struct html_report *report)
{
	fputs("</section>\n", report->file);
}

void html_sentence(const struct html_report *report, const struct html_run *run, const char *text)
{
	const bool named = run != NULL && report->count > 1;
	fputs("<p>", report->file);
	if (named) {
		svg_text(run->folder, report->file);
		fputs(": ", report->file);
	}
	svg_text(text, report->file);
	const size_t length = strlen(text);
	fputs(length > 0 && text[length - 1] == '.' ? "</p>\n" : ".</p>\n", report->file);
}

static void write_head(const struct html_report *report)
{
	FILE *file = report->file;
	fputs("<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"/><meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n<title>furrow report: ", file);
	for (size_t i = 0; i < report->count; i++) {
		fputs(i > 0 ? ", " : "", file);
		svg_text(report->runs[i].folder, file);
	}
	fprintf(file, "</title>\n<style>\n%s</style></head><body>\n<h1>", html_style);
	for (size_t i = 0; i < report->count; i++) {
		fputs(i > 0 ? ", " : "", file);
		svg_text(report->runs[i].folder, file);
	}
	fprintf(file, "</h1>\n<p class=\"small\">%s, told by furrow report " FURROW_VERSION "</p>\n", report->count > 1 ? "Drives beside each other" : "A drive");
}

enum status html_report_write(const struct html_report *report)
{
	write_head(report);
	html_tables_run(report);
	html_tables_differences(report);
	html_tables_results(report);
	TRY(html_map_write(report));
	TRY(html_cameras_write(report));
	TRY(html_curves_write(report));
	TRY(html_digging_write(report));
	TRY(html_curves_rut(report));
	html_tables_volume(report);
	TRY(html_curves_steps(report));
	TRY(html_curves_cache(report));
	html_tables_soils(report);
	html_tables_notes(report);
	html_tables_settings(report);
	fputs("</body></html>\n", report->file);
	return STATUS_OK;
}
