% Draws run.csv of a recording of end-effector-hal: MATLAB, or GNU Octave 6 and later.
%
%   cd runs/demo/fails-once; plot_run                       % a window
%   octave --no-gui --eval "plot_run('run.csv', 'run.png')"  % a file
%
% Above: the states as step curves with an offset, their integers at the left (Table II of "A ROS-Based Hardware
% Abstraction Layer for Multifunction End-Effector Integration", Figs. 7 to 9). Below: gauge pressures; a vacuum is negative.

function plot_run(table, picture)
  if nargin < 1
    table = 'run.csv';
  end
  file = fopen(table, 'r');
  if file < 0
    error('plot_run: %s cannot be read; `eehal plot FOLDER --csv` writes it.', table);
  end
  names = strsplit(strtrim(fgetl(file)), ',');
  cells = textscan(file, repmat('%f', 1, numel(names)), 'Delimiter', ',');
  fclose(file);
  data = cell2mat(cells);
  time = data(:, 1);
  pressures = find(strcmp(names, 'alarms'), 1) + 1:numel(names);  % or other quantities: the unit ends the name
  states = setdiff(2:numel(names), [pressures, find(strcmp(names, 'alarms'))]);

  if nargin < 2
    sheet = figure();
  else
    sheet = figure('visible', 'off');
  end
  set(sheet, 'paperunits', 'inches', 'paperposition', [0, 0, 12, 9]);
  if isempty(pressures)
    subplot(1, 1, 1);
  else
    subplot(3, 1, 1:2);
  end
  hold on;
  foot = 0;
  ticks = [];
  marks = {};
  for column = fliplr(states)
    values = data(:, column);
    low = min(values);
    stairs(time, values - low + foot, 'linewidth', 1.2);
    text(time(1), max(values) - low + foot + 0.6, [' ', strrep(names{column}, '_', ' ')]);
    found = unique(values(~isnan(values)))';
    ticks = [ticks, found - low + foot];
    marks = [marks, arrayfun(@(value) sprintf('%d', value), found, 'UniformOutput', false)];
    foot = foot + max(values) - low + 2.2;
  end
  hold off;
  set(gca, 'ytick', ticks, 'yticklabel', marks, 'ylim', [-0.5, foot]);
  xlim([time(1), time(end) + eps]);
  ylabel('state (with an offset per curve)');
  set(gca, 'xgrid', 'on');

  if ~isempty(pressures)
    subplot(3, 1, 3);
    plot(time, data(:, pressures), 'linewidth', 1.2);
    xlim([time(1), time(end) + eps]);
    if any(cellfun('isempty', regexp(names(pressures), '_gauge_kpa$')))
      ylabel('gauge kPa, or as named');
    else
      ylabel('gauge kPa');
    end
    legend(strrep(strrep(names(pressures), '_gauge_kpa', ''), '_', ' '), 'location', 'eastoutside');
    set(gca, 'xgrid', 'on');
  end
  xlabel('time since start [s]');
  if nargin > 1
    print(sheet, picture, '-dpng', '-r100');
  end
end
