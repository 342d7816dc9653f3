function m = nanmean(x)
% Mean of each column without its NaN; Octave has no such function.
known = ~isnan(x);
x(~known) = 0;
m = sum(x, 1) ./ sum(known, 1);
end
